"""Curves that the fits of a record of `palermo_virtual` simulate, by what they are for, and processor time.

    python -m freerock_bench.curves config2_marble

A curve up to a horizon, and a swing from impact to impact, counts as its share of the run.
"""

import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import numpy as np

from freerock.config.campaign import load_campaign
from freerock.config.step_settings import fit_settings, record_settings
from freerock.identification.start import whole_s
from freerock.jobs.make_fits import make_fits
from freerock.jobs.make_record import make_record
from freerock.models import kernel, series, simulate
from freerock.models.block import Block
from freerock.runs.motion import Motion
from freerock.selection.candidates import Allowed
from freerock.selection.identify import Identified, identify_record

PURPOSES = {
    "paper_fit": "the paper's fits",
    "scan": "scans",
    "_round": "rounds",
    "_ends": "first swings and whole runs",
}
WITHIN = {"_quotient": "by numbers", "tangents": "by impacts", "by_inputs": "by inputs"}
SOLVERS: list[tuple[Any, str, Callable[..., Any]]] = [
    (series, "integrate_series", lambda given: given[2][-1]),
    (kernel, "integrate", lambda given: given[4][-1]),
    (simulate, "housner_motion", lambda given: given[1][-1]),
    (simulate, "swings_by_series", lambda given: 3 * (given[1][-1] - np.nanmin(given[4][:, 0], initial=0.0))),
]


def identify(block: Block, motions: Mapping[int, Motion], allowed: Allowed) -> Identified:
    """As `identify_record`, and print what it took per run."""
    identify_record(block, motions, allowed)  # whatever is compiled or read first
    seconds = -time.process_time()
    found = identify_record(block, motions, allowed)
    seconds += time.process_time()
    counts, run_s = Counter[str](), sum(whole_s(motion) for motion in motions.values())
    with ExitStack() as patched:
        for module, name, span_s in SOLVERS:
            patched.enter_context(patch.object(module, name, _counted(getattr(module, name), span_s, counts)))
        identify_record(block, motions, allowed)
    print(f"{seconds / len(motions):.2f} s of processor time and {counts.total() / run_s:.0f} curves a run")
    for purpose, of_it in counts.most_common():
        print(f"{of_it / run_s:6.1f}  {purpose}")
    return found


def _counted(function: Callable[..., Any], span_s: Callable[..., Any], counts: Counter[str]) -> Any:
    def called(*given: Any, **named: Any) -> Any:
        counts[_purpose()] += span_s(given)
        return function(*given, **named)

    return called


def _purpose() -> str:
    """What the callers of a curve make of it."""
    frame, found = sys._getframe(2), ["others", "residuals"]
    while frame.f_back:
        frame = frame.f_back
        name = frame.f_code.co_name
        found = [PURPOSES.get(name, found[0]), WITHIN.get(name, found[1])]
    return ", ".join(found)


def main(test: str = "config2_marble") -> None:
    """Make the record, fit it, print."""
    campaign = load_campaign(Path("config/campaigns/palermo_virtual.yaml"))
    (record,) = (each for each in campaign.records if each.test == test)
    with TemporaryDirectory() as folder:
        made = Path(folder, "record.nc")
        make_record(record_settings(campaign, record, ""), made)
        make_fits(fit_settings(campaign, record), made, Path(folder, "fits.nc"), identify)


if __name__ == "__main__":
    main(*sys.argv[1:])
