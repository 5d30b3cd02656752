"""The plan of a campaign as printed: standard errors in per cent of the values."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from freerock.models.laws import MODEL_LABELS, SYMBOLS


def plan_text(frame: pd.DataFrame, labels: Mapping[str, str] | None = None) -> str:
    """The plan as a reader sees it: standard errors in per cent of the values, and why some are missing.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.identification.plan.plan`.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.

    Returns
    -------
    str
        A line per case with a column per parameter; then a line per reason.
    """
    frame = frame.replace({"block": labels or {}, "foundation": labels or {}})
    rows = frame.assign(
        duration=frame["duration_s"].map("{:g} s".format),
        rate=frame["sampling_rate_hz"].map("{:g} Hz".format),
        angle=frame["release_angle_deg"].map("{:g}°".format),
        parameter=frame["model"].map(MODEL_LABELS) + " " + frame["parameter"].map(SYMBOLS),
        percent=[_percent(*pair) for pair in zip(frame["stderr"], frame["value"], strict=True)],
    )
    case = ["block", "foundation", "laser", "sensor", "duration", "rate", "angle"]
    alike = [name for name in case if rows[name].nunique() == 1]
    shown = [name for name in case if name not in alike] or ["angle"]
    table = rows.set_index([*shown, "parameter"])["percent"].unstack(sort=False)
    title = ", ".join(["Standard errors in %", *rows[alike].iloc[0]])
    reasons = [
        f"{row.block} on {row.foundation} from {row.angle}: {row.note}"
        for row in rows.itertuples()
        if row.note
    ]
    return "\n".join([title, table.to_string(), *dict.fromkeys(reasons)])


def _percent(stderr: float, value: float) -> str:
    return f"{100 * stderr / value:.2g}" if np.isfinite(stderr) else "–"
