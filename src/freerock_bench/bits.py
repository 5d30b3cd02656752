"""Converters of few bits: is a clean run still ok, its noise known and its k as certain as stated?

`clean_records` on foundations, which share nothing with the laws that are fitted, with white noise of
1, 2 and 5 mV, through converters of 8 to 24 bits over ±10.5 V, go as volts the public way to runs and the fit
of the law that is true.

    python -m freerock_bench.bits results/studies/bits.csv full docs/evidence.md

measures (`small`: two records of each; `full`: 54, in five minutes of processor time) and renews the table in
the documentation, where it is named.
"""

import math
import sys

import numpy as np
import pandas as pd

from freerock.identification.fit import fit_run
from freerock.identification.significance_levels import NORMAL_95
from freerock_bench.clean_records import kind_of, truth_of
from freerock_bench.document import in_markdown
from freerock_bench.harness import Study
from freerock_bench.virtual_run import SEED, Row

BITS, SIGMAS_MV = (8, 10, 12, 14, 16, 24), (1.0, 2.0, 5.0)
SPAN_V = 21.0  # of the converter
SIZES = {"small": 2, "full": 54}  # records of each; eighteen make a round of scenes
ALIKE = 0.05  # by which σ may be off
COLUMNS = ["bits", "sigma_mv", "record", "scene", "level", "names", "sigma_ratio", "noise", "error", "stderr"]
COLUMNS += ["inside"]


def cases(size: str) -> list[tuple[int, float, int]]:
    """Every converter and noise on scenes in turn."""
    scenes = [i for i in range(2 * max(SIZES.values())) if kind_of(i) != "rigid"][: SIZES[size]]
    return [(bits, sigma, i) for i in scenes for bits in BITS for sigma in SIGMAS_MV]


def rows_of(case: tuple[int, float, int]) -> list[Row]:
    """The row of one record.

    bits; sigma_mv, noise before the converter; record, scene; level and names of the run's verdict;
    sigma_ratio, σ found over that of noise and rounding; of the fit of the true law, noise (whether its
    residual agrees with it), error and stderr of k [N/m²], inside: 1.96 stderr hold it. NaN where there is no
    run or no fit.
    """
    bits, sigma_mv, i = case
    truth, step = truth_of(i), SPAN_V / 2**bits
    draw = np.random.default_rng([SEED, bits, round(sigma_mv), i])
    offset, volts = draw.uniform(), truth.volts + 1e-3 * sigma_mv * draw.standard_normal(len(truth.volts))
    volts = step * (np.rint(volts / step + offset) - offset)
    judged, found = truth.first_run(volts)
    row = {"bits": bits, "sigma_mv": sigma_mv, "record": i, "scene": " ".join(truth.names), **judged}
    if found is None:
        return [row]
    row["sigma_ratio"] = found.noise_v / math.hypot(1e-3 * sigma_mv, step / math.sqrt(12))
    if found.motion is None:
        return [row]
    fit = fit_run(truth.candidate, truth.scene.block, found.motion)
    if fit.success:
        error, stderr = fit.value[0] - truth.parameters["k"], fit.stderr[0]
        row |= {"noise": bool(fit.diagnostics["noise"]), "error": error, "stderr": stderr}
        row["inside"] = bool(abs(error) <= NORMAL_95 * stderr)
    return [row]


def markdown(frame: pd.DataFrame) -> str:
    """A row per noise and converter: the step over σ, records, shares ok and failed, of σ within `ALIKE`, of
    fits whose residual agrees with the noise, and of k inside."""
    rows = []
    for (sigma_mv, bits), own in frame.groupby(["sigma_mv", "bits"]):
        usable = own[own["level"] != "fail"]
        shares = [(own["level"] == level).mean() for level in ("ok", "fail")]
        shares.append(((usable["sigma_ratio"] - 1).abs() <= ALIKE).mean())
        shares += [usable[name].dropna().astype(float).mean() for name in ("noise", "inside")]
        step = SPAN_V / 2**bits / (1e-3 * sigma_mv)
        cells = [f"{sigma_mv:g}", bits, f"{step:.2g}", len(own)]
        rows.append([*cells, *(f"{100 * share:.0f} %" for share in shares)])
    heads = ["noise [mV]", "bits", "a step [σ]", "records", "ok", "failed"]
    return in_markdown([*heads, "σ within 5 %", "fit is noise", "k inside"], rows)


STUDY = Study(cases, rows_of, COLUMNS, "bits", markdown)
run = STUDY.run

if __name__ == "__main__":
    STUDY.main(*sys.argv[1:])
