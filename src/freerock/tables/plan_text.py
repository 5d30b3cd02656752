"""The plan of a campaign as printed."""

import re
from collections.abc import Mapping

import numpy as np
import pandas as pd

from freerock.models.free_parameters import SYMBOLS
from freerock.models.laws import MODEL_LABELS

UNIT = re.compile("_(fraction|(m|kg|deg|ms)(_m2|_s2)?)$")  # at the end of an input's name


def plan_text(frame: pd.DataFrame, labels: Mapping[str, str] | None = None) -> str:
    """What one run will tell of each parameter, in the case of least u_total, and why numbers are missing.

    Parameters
    ----------
    frame : pandas.DataFrame
        From `freerock.planning.plan.plan`.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.

    Returns
    -------
    str
        A line per foundation, parameter and block: bound by noise and total u in per cent of the value, the
        input that matters most with its share of u², and the case; then a line per reason.
    """
    names = {"block": labels or {}, "foundation": labels or {}}
    printed = frame.replace(names).assign(
        parameter=frame["model"].map(MODEL_LABELS) + " " + frame["parameter"].map(SYMBOLS)
    )
    keys = ["foundation", "parameter", "block"]
    rows = []
    for key, own in printed.groupby(keys, sort=False):
        best = own.sort_values("u_total", kind="stable").iloc[0]
        first, case = UNIT.sub("", best.first_input).replace("_", " "), f"{best.duration_s:g} s, "
        case = f"{best.sensor}, {case}{best.sampling_rate_hz:g} Hz, {best.release_angle_deg:g}°"
        told = {
            "noise / %": _percent(best.stderr, best.value),
            "total / %": _percent(best.u_total, best.value),
            "input that matters most": f"{first} of {best.first_owner}" if first else "–",
            "share of u²": f"{100 * best.first_share:.0f} %" if first else "–",
            "case": "–" if best.note else case,
        }
        rows.append(dict(zip(keys, key, strict=True)) | told)
    table = pd.DataFrame(rows).sort_values(keys, key=lambda own: pd.factorize(own)[0]).set_index(keys)
    title = "Standard uncertainty by one run: by noise alone (Cramér–Rao), and total with inputs"
    missing = printed[printed["note"] != ""]
    places = missing["block"] + " on " + missing["foundation"] + " from "
    reasons = places + missing["release_angle_deg"].map("{:g}°: ".format) + missing["note"]
    return "\n".join([title, table.to_string(), *dict.fromkeys(reasons)])


def _percent(stderr: float, value: float) -> str:
    return f"{100 * stderr / value:.2g}" if np.isfinite(stderr) else "–"
