"""The next run of a record as a band: of peaks and impacts of motions whose impacts and law scatter."""

import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from operator import attrgetter

import numpy as np
import pandas as pd

from freerock.arrays import Floats
from freerock.columns import table_of
from freerock.config.fit_settings import FitSettings
from freerock.identification.run_model import RTOL_SCREENING, Point, RunModel
from freerock.models.block import Block
from freerock.populations.estimate import Estimate
from freerock.populations.random_effects import exponential, likely_spreads
from freerock.runs.motion import Motion

DRAWS = 200  # motions of a band
MOST_PEAKS = 12  # of a run that are predicted
RATE_HZ = 250.0  # of a motion, at which a peak is off by less than 1e-4 of itself
ENOUGH = 1.2  # times the impact after the last that counts: until then a motion is computed first
LEAST_NOISE = 1e-5  # relative standard error of a parameter
MOST_R = 0.9999  # of a rigid block that still comes to rest
INSIDE = (2.5, 50.0, 97.5)  # per cent
# Columns of a peak and of the impact before it: measured, band, and whether that holds it.
OF_PEAK = ("peak_deg", "low_deg", "median_deg", "high_deg", "inside")
OF_IMPACT = ("impact_s", "impact_low_s", "impact_median_s", "impact_high_s", "impact_inside")


def bands(
    estimates: Iterable[Estimate],
    motions: Callable[[str], Mapping[int, Motion]],
    blocks: Mapping[str, Block],
    swings: Mapping[tuple[str, int], tuple[Floats, Floats]],
    debonding: str = "geometric",
) -> pd.DataFrame:
    """Where the peaks and impacts of a run should lie, by the other runs of its record.

    The parameters are drawn about the mean of the other runs, with its noise and with spreads between runs as
    they are likely; the rate after each impact is multiplied by 1 + δ with δ drawn from σ_r; the release is
    that of the run, with its standard errors.

    Parameters
    ----------
    estimates : iterable of Estimate
        Of the candidate selected for each record, the runs of a test one after the other.
    motions : callable
        Takes a test and returns its runs' motions by run number; called once per test.
    blocks : mapping of str to Block
        The campaign's blocks by name.
    swings : mapping of (str, int) to (ndarray, ndarray)
        Measured peaks |θ_n| after the n-th impact [°], and when that was [s], by test and run.
    debonding : str
        "geometric" or "tensionless".

    Returns
    -------
    pandas.DataFrame
        Columns of predictions.csv, a row per run and peak.
    """
    known, rows = list(estimates), list[dict[str, object]]()
    for test, every in groupby(known, attrgetter("test")):
        alike, measured = list(every), motions(test)
        for own in alike:
            others = [each for each in alike if each.run != own.run and each.model == own.model]
            of_law = [
                each
                for each in known
                if each is not own and (each.model, each.foundation) == (own.model, own.foundation)
            ]
            known_of = swings.get((own.test, own.run), (np.empty(0), np.empty(0)))
            seen = np.stack(known_of)[:, :MOST_PEAKS]
            if not others or own.run not in measured or not seen.size:
                continue
            drawn = _drawn(others, of_law, np.random.default_rng(_seed(own)))
            low, middle, high = predicted(own, drawn, measured[own.run], blocks[own.block], debonding, seen)
            of_run = {"campaign": own.campaign, "test": own.test, "run": own.run, "block": own.block}
            of_run |= {"foundation": own.foundation, "model": own.model, "n_runs": len(others)}
            columns: dict[str, Iterable[object]] = {"peak": range(1, seen.shape[1] + 1)}
            for i, each in enumerate((OF_PEAK, OF_IMPACT)):
                found = seen[i], low[i], middle[i], high[i], (low <= seen)[i] & (seen <= high)[i]
                columns |= zip(each, found, strict=True)
            rows += [
                of_run | dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)
            ]
    return table_of("predictions", rows)


def predicted(
    own: Estimate,
    drawn: Iterable[tuple[dict[str, float], float]],
    motion: Motion,
    block: Block,
    debonding: str,
    seen: Floats,
) -> tuple[Floats, Floats, Floats]:
    """2.5, 50 and 97.5 % of as many peaks [°] and impacts [s] as were seen of a run, predicted by others.

    Shape (2, n_peaks) each, as of `seen`. A motion is computed to its end only where it is slow.
    """
    rng, drawn_swings = np.random.default_rng(_seed(own) + 1), []
    whole_s, n_peaks = np.arange(0.0, motion.time_s[-1], 1 / RATE_HZ), seen.shape[1]
    before_s, last_s = np.append(0.0, seen[1])[-2:]
    enough_s = whole_s[whole_s < ENOUGH * (2 * last_s - before_s)]  # swings become shorter
    read = replace(motion, laboratory=own.laboratory(block, motion.view))
    model = RunModel(own.model, block, read, FitSettings(debonding=debonding))
    inputs = np.array([own.moved[source] for source in model.inputs])
    for law, sigma_r in drawn:
        impacts = rng.normal(0.0, sigma_r, 4 * MOST_PEAKS) if sigma_r > 0 else np.zeros(0)
        point = Point(law | _released(own, motion, rng), inputs, impacts)
        found = peaks_of(enough_s, model.curve(point, enough_s, RTOL_SCREENING))
        if found.shape[1] < n_peaks:
            found = peaks_of(whole_s, model.curve(point, whole_s, RTOL_SCREENING))
        found = found[:, :n_peaks]
        rests = np.array([[0.0], [motion.time_s[-1]]])  # no peak, and no impact within the run
        drawn_swings.append(np.hstack([found, np.tile(rests, n_peaks - found.shape[1])]))
    low, middle, high = np.percentile(drawn_swings, INSIDE, axis=0)
    return low, middle, high


def _released(own: Estimate, motion: Motion, rng: np.random.Generator) -> dict[str, float]:
    """Release of a run, drawn about what its fit found by the standard errors of the measured one."""
    found = {"theta0": motion.theta0, "t0": 0.0, **own.release}
    found["theta0"] += rng.normal(0.0, motion.theta0_stderr)
    found["t0"] += rng.normal(0.0, motion.t0_stderr)
    return found


def _seed(own: Estimate) -> int:
    return zlib.crc32(f"{own.test} {own.run} {own.model}".encode())


def peaks_of(time_s: Floats, theta: Floats) -> Floats:
    """Largest |θ| after each zero crossing [°] and when that was [s], shape (2, n_swings)."""
    sign = np.sign(theta)
    before = np.flatnonzero(sign[1:] != sign[:-1])
    after = before + 1
    step_s, turned = time_s[after] - time_s[before], theta[after] - theta[before]
    crossed = time_s[before] - theta[before] * step_s / turned
    peaks = np.maximum.reduceat(np.abs(theta), after)[:-1]  # of the pieces between two crossings
    return np.stack([np.degrees(peaks), crossed[: len(peaks)]])


def _drawn(
    others: list[Estimate], known: Sequence[Estimate], rng: np.random.Generator
) -> Iterator[tuple[dict[str, float], float]]:
    """Parameters of a run like the others, and σ_r of its impacts.

    `known`: runs whose differences within their records tell the spread between runs.
    """
    names, n = list(others[0].parameters), len(others)
    mean = np.mean([_logarithms(each) for each in others], axis=0)
    noise = np.mean([_noise(each) for each in others], axis=0)
    sigma_r = float(np.mean([each.sigma_r for each in others]))
    shifts = rng.multivariate_normal(0 * mean, noise / n, DRAWS, method="eigh")
    shifts += np.sqrt(1 + 1 / n) * _spreads(known, rng) * rng.standard_normal(shifts.shape)
    for shift in shifts:
        law = dict(zip(names, exponential(mean + shift).tolist(), strict=True))
        yield law | ({"r": min(law["r"], MOST_R)} if "r" in law else {}), sigma_r


def _spreads(known: Sequence[Estimate], rng: np.random.Generator) -> Floats | float:
    """Spreads of ln p between the runs of a record, drawn from what is likely, shape (n_draws, n_parameters).

    0 where no record has two runs.
    """
    records = [list(own) for _, own in groupby(known, attrgetter("test"))]
    records = [own for own in records if len(own) > 1]
    if not records:
        return 0.0
    found = []
    for j in range(len(known[0].parameters)):
        samples = [
            (np.array([_logarithms(each)[j] for each in own]), np.array([_noise(each)[j, j] for each in own]))
            for own in records
        ]
        chances, squares = likely_spreads(samples)
        found.append(np.sqrt(rng.choice(squares, DRAWS, p=chances)))
    return np.column_stack(found)


def _logarithms(own: Estimate) -> Floats:
    return np.log(list(own.parameters.values()))


def _noise(own: Estimate) -> Floats:
    """Covariance of ln p without the errors of inputs, which the runs of a record share."""
    values = np.array(list(own.parameters.values()))
    shifts = np.array([*own.shifts.values()]).reshape(-1, values.size)
    noise = own.covariance[: values.size, : values.size] / np.outer(values, values) - shifts.T @ shifts
    return np.asarray(noise + np.diag(np.maximum(LEAST_NOISE**2 - np.diag(noise), 0.0)))
