"""Restitutions that do not go evenly from impact to impact."""

import math
import re

import numpy as np
import pytest

from freerock.models.block import Block
from freerock.runs.impacts import Impacts, restitution_covariance, restitution_from_peaks
from freerock.runs.reasons_as_measured import reasons_of_impacts

BLOCK = Block(0.28, 0.07, 5.84)
STDERR = 5e-5  # of a peak [rad]


def run(r, stderr=STDERR, theta0=0.17, wrong=None):
    """Impacts of a block with these restitutions; with errors of its peaks [rad], if `wrong`."""
    peaks = [theta0]
    for each in r:
        energy = each**2 * (math.cos(BLOCK.theta_cr - peaks[-1]) - math.cos(BLOCK.theta_cr))
        peaks.append(BLOCK.theta_cr - math.acos(energy + math.cos(BLOCK.theta_cr)))
    peaks = np.array(peaks) + (0.0 if wrong is None else wrong)
    seen, stderrs = restitution_from_peaks(peaks[:-1], stderr, peaks[1:], stderr, BLOCK)
    n = len(seen)
    sides = (-1.0) ** np.arange(n + 1)
    empty, one = np.full(n, np.nan), np.full(n, stderr)
    peaks = peaks * sides
    return Impacts(empty, empty, peaks[:-1], one, peaks[1:], one, seen, stderrs, 0.0)


def names(impacts):
    return [(reason.verdict, reason.name) for reason in reasons_of_impacts(impacts, BLOCK)]


EVENLY = 0.94 - 0.004 * np.arange(12) / 10 - 0.01 * 0.5 ** np.arange(12)


def test_covariance_is_that_of_peaks_with_errors():
    draw = np.random.default_rng(1)
    drawn = np.array(
        [run(EVENLY[:5], wrong=STDERR * draw.standard_normal(6)).restitution for _ in range(4000)]
    )
    known = restitution_covariance(run(EVENLY[:5]), BLOCK)
    assert np.cov(drawn.T) == pytest.approx(known, rel=0.1, abs=0.05 * known.max())
    assert known[0, 1] < 0 and known[0, 2] == 0


@pytest.mark.parametrize("n", [0, 1, 2, 3, 4, 6, 9, 12])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_smooth_curve_is_even(n, sign):
    impacts = run((0.9 + sign * (EVENLY - 0.9))[:n]) if n else run([0.9, 0.9])
    assert names(impacts) == []


@pytest.mark.parametrize(("n", "by", "name"), [(12, 0.003, "alternating"), (6, 0.01, "uneven")])
@pytest.mark.parametrize("sign", [1, -1])
def test_every_other_impact_is_seen(n, by, name, sign):
    impacts = run(EVENLY[:n] + sign * by * (-1) ** np.arange(n))
    assert names(impacts) == [("warn", f"{name}_restitution")]


@pytest.mark.parametrize("impact", [1, 2, 5, 8])
def test_one_impact_is_seen_and_named(impact):
    r = EVENLY.copy()
    r[impact - 1] -= 0.02
    (reason,) = reasons_of_impacts(run(r), BLOCK)
    assert (reason.verdict, reason.name) == ("warn", "outlying_restitution")
    said = re.match(
        r"restitution of impact (\d+) is (0\.\d+) below the value that its neighbours predict: ", reason.text
    )
    assert said and int(said[1]) == impact and float(said[2]) == pytest.approx(0.02, abs=0.002)
    assert ";" not in reason.text


@pytest.mark.slow
@pytest.mark.parametrize("n", [3, 5, 6, 8, 12])
@pytest.mark.parametrize("sigma_r", [0.01, 0.03])
def test_impacts_of_a_laboratory_scatter_without_a_warning(n, sigma_r):
    draw = np.random.default_rng(n)
    warned = [bool(names(run(EVENLY[:n] * (1 + sigma_r * draw.standard_normal(n))))) for _ in range(400)]
    assert np.mean(warned) < 0.01
