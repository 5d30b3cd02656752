"""Flags of the samples of signals of known make."""

import numpy as np
import pytest

from freerock.rotation.flags import FLAGS, Limits, flag_samples

LIMITS = Limits(-0.1, 10.1, 10.2, 0.01)
STEP = 5e-4
TIME = STEP * np.arange(8000)


def swinging(noise=0.002, seed=1):
    """Volts of a block at rest that swings from 1 s to 3 s."""
    moving = (TIME > 1) & (TIME < 3)
    swing = np.where(moving, np.sin(np.pi * (TIME - 1)) ** 3 * np.cos(9 * TIME), 0.0)
    return 5 + 2 * swing + noise * np.random.default_rng(seed).standard_normal(TIME.size)


def flagged(volts, name):
    return np.flatnonzero(flag_samples(volts, LIMITS, step=STEP) & FLAGS[name])


def test_a_good_signal_has_no_flag():
    for seed in range(20):
        assert not flag_samples(swinging(seed=seed), LIMITS, step=STEP).any()


@pytest.mark.parametrize("bits", [16, 24])
def test_saturation(bits):
    count = 21 / 2**bits
    volts = np.rint(np.minimum(swinging(), 6.0) / count) * count
    found = flagged(volts, "saturated")
    assert set(found) == set(np.flatnonzero(volts == volts.max())) and found.size > 50
    assert not flagged(volts, "dropout").any()


@pytest.mark.parametrize("at", [500, 2500, 3300])
@pytest.mark.parametrize("lasts", [8, 40, 200])
def test_dropouts(at, lasts):
    frozen, off = swinging(), swinging()
    frozen[at : at + lasts] = frozen[at - 1]
    off[at : at + lasts] = 1e-4 * np.random.default_rng(2).standard_normal(lasts)
    assert set(range(at, at + lasts)) <= set(flagged(frozen, "dropout"))
    assert set(flagged(off, "dropout")) == set(range(at, at + lasts))


@pytest.mark.parametrize("at", [500, 2500, 3300])
@pytest.mark.parametrize("height", [0.05, -0.5])
@pytest.mark.parametrize("lasts", [1, 3])
def test_spikes(at, height, lasts):
    volts = swinging()
    volts[at : at + lasts] += height
    assert list(flagged(volts, "spike")) == list(range(at, at + lasts))


def overshooting():
    """A jump and half of it back, by 8.8 and 4.6 times the usual noise, where there is less of it."""
    noise = np.where(TIME < 0.6, 0.0001, 0.002)
    volts = 5 + noise * np.random.default_rng(1).standard_normal(TIME.size)
    volts[600:] += 0.007
    volts[600] += 0.0076
    return volts


@pytest.mark.parametrize(
    "volts",
    [
        swinging(0.0),
        np.round(5 + 0.01 * np.sin(np.arange(8000) / 20), 2),
        np.where(TIME < 2, 5.0, 6.0),
        np.abs(swinging(1e-4) - 5) + 1,
        overshooting(),
    ],
    ids=["no noise", "coarse converter", "a step", "a reading without sign", "a step that overshoots"],
)
def test_what_is_no_fault(volts):
    assert not flag_samples(volts, LIMITS, step=STEP).any()
