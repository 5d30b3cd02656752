"""Flags and faults of signals of known make."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from freerock.errors import FreerockError
from freerock.models.block import Block
from freerock.rotation.ac_coupling import ac_cutoff
from freerock.rotation.faults import flagged_faults
from freerock.rotation.flags import FLAGS, Limits, flag_samples
from freerock.rotation.rotation import find_rotation
from freerock.rotation.sensor import Laser

LIMITS = Limits(-0.1, 10.1, 10.2, 0.01)
BLOCK, LASER = Block(0.28, 0.07, 5.84), Laser("horizontal", 0.2, 0.1)
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


def test_levels_and_limits():
    volts = swinging()
    volts[100:110] = 10.2 + np.linspace(-0.009, 0.009, 10)
    volts[200], volts[201], volts[202], volts[203] = 10.12, -0.2, np.nan, np.inf
    assert list(flagged(volts, "error_level")) == list(range(100, 110))
    assert list(flagged(volts, "out_of_range")) == [200, 201, 203]
    assert list(flagged(volts, "dropout")) == [202]


def test_an_error_level_within_the_valid_output():
    inside = Limits(-0.1, 10.1, 0.0, 0.02)
    volts = swinging()
    volts[2000:7000] = 0.004 * np.random.default_rng(1).standard_normal(5000)
    flags = flag_samples(volts, inside, step=STEP)
    assert list(np.flatnonzero(flags & FLAGS["error_level"])) == list(range(2000, 7000))
    assert not (flags & FLAGS["out_of_range"]).any()


def test_a_passage_of_an_error_level_costs_only_the_samples_at_it():
    volts = swinging()
    flags = flag_samples(volts, Limits(-0.1, 10.1, 6.0, 0.02), step=STEP)
    np.testing.assert_array_equal(flags == FLAGS["error_level"], np.abs(volts - 6.0) <= 0.02)
    assert 0 < np.count_nonzero(flags) < 0.01 * volts.size


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


@pytest.mark.parametrize(
    "volts",
    [
        swinging(0.0),
        np.round(5 + 0.01 * np.sin(np.arange(8000) / 20), 2),
        np.where(TIME < 2, 5.0, 6.0),
        np.abs(swinging(1e-4) - 5) + 1,
    ],
    ids=["no noise", "coarse converter", "a step", "a reading without sign"],
)
def test_what_is_no_fault(volts):
    assert not flag_samples(volts, LIMITS, step=STEP).any()


def test_near_stretches_are_told_as_one():
    flags = np.zeros(TIME.size, np.uint8)
    flags[100:105] = flags[110:112] = flags[1000] = FLAGS["spike"]
    flags[102] |= FLAGS["out_of_range"]
    assert [(f.name, f.start_s, f.end_s, f.note) for f in flagged_faults(TIME, flags)] == [
        ("out_of_range", TIME[102], TIME[102], "1 sample"),
        ("spike", TIME[100], TIME[111], "7 samples"),
        ("spike", TIME[1000], TIME[1000], "1 sample"),
    ]


def test_ac_coupling_is_told_by_a_held_angle():
    t = 1e-3 * np.arange(12_000)
    held = 5.0 + np.where((t > 3) & (t < 5), 1.0, 0.0) * np.cos(np.maximum(t - 5, 0))
    noisy = held + 0.002 * np.random.default_rng(1).standard_normal(t.size)
    assert ac_cutoff(1e-3, noisy) is None
    rate = 2 * np.pi * 0.1
    coupled = np.zeros(t.size)
    for i in range(1, t.size):
        coupled[i] = (coupled[i - 1] + noisy[i] - noisy[i - 1]) / (1 + rate * 1e-3)
    assert ac_cutoff(1e-3, coupled) == pytest.approx(0.1, rel=0.05)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(
    kind=st.sampled_from(["noise", "walk", "steps", "swing", "spoilt"]),
    n=st.integers(2, 6000),
    scale=st.sampled_from([1e-300, 1e-9, 1e-3, 1.0, 1e3, 1e300]),
    centre=st.sampled_from([0.0, 5.0, -1e6]),
    seed=st.integers(0, 1000),
    units=st.sampled_from(["V", "mA", "mm", "deg"]),
)
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_any_signal_is_answered_or_refused(kind, n, scale, centre, seed, units):
    signal = centre + scale * random_signal(kind, n, np.random.default_rng(seed))
    laser = Laser("horizontal", 0.2, 0.1, units=units)
    try:
        found = find_rotation(np.arange(n) / 500, signal, laser, BLOCK)
    except FreerockError as error:
        assert "\n" not in str(error)
        return
    assert found.theta.size == n and np.isfinite(found.attrs["zero_stderr_rad"])


def random_signal(kind, n, draw):
    """A signal of nonsense: noise, walks, steps, swings, with what converters add."""
    base = {
        "noise": lambda: draw.standard_normal(n),
        "walk": lambda: np.cumsum(draw.standard_normal(n)),
        "steps": lambda: np.repeat(draw.standard_normal(n // 50 + 1), 50)[:n],
        "swing": lambda: np.exp(-np.arange(n) / 400) * np.cos(np.arange(n) / draw.uniform(3, 90)),
        "spoilt": lambda: np.round(draw.standard_normal(n), draw.integers(0, 3)),
    }[kind]()
    if kind == "spoilt":
        base[draw.integers(0, n, n // 10 + 1)] = draw.choice([np.nan, np.inf, -np.inf, 0.0, 10.2])
    return base
