import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from freerock.noise import still_phases
from freerock.noise.still_phases import stationary_phases

RATE = 1000.0


def smooth(time, start, end):
    share = np.clip((time - start) / (end - start), 0, 1)
    return share**2 * (3 - 2 * share)


def swing(t, decay=1.0):
    """Free oscillation from 1 about 0 whose frequency rises as it dies, as rocking does; 1 before t = 0."""
    return np.where(t < 0, 1.0, np.exp(-decay * np.maximum(t, 0)) * np.cos(2 * np.pi * (1 + 0.4 * t) * t))


def record(generator, releases, *, noise=1e-3, zero=0.3, overshoot=0.1):
    """Rest, then for each (angle, held_s): a clumsy tilt, a hold, a release, 8 s to rest."""
    clock, parts, holds = 2.0, [], []
    for angle, held_s in releases:
        parts.append((clock, angle))
        holds.append((clock + 2.0, clock + 2.0 + held_s))
        clock += 2.0 + held_s + 8.0
    time = np.arange(0, clock, 1 / RATE)
    signal = np.zeros_like(time)
    for (start, angle), (_, release) in zip(parts, holds, strict=True):
        tilt = smooth(time, start, start + 1.2) + overshoot * (
            smooth(time, start + 1.1, start + 1.4) - smooth(time, start + 1.5, start + 1.9)
        )
        own = (time >= start) & (time < release + 8)
        signal[own] = angle * np.where(time < release, tilt, swing(time - release))[own]
    return time, zero + signal + noise * generator.standard_normal(time.size), holds


def kinds(phases):
    return [phase.kind for phase in phases]


def test_rest_and_held_are_kept_apart():
    time, signal, holds = record(np.random.default_rng(1), [(1.0, 2.0), (-0.8, 1.5), (0.9, 1.0)])
    phases = stationary_phases(time, signal)
    assert kinds(phases) == ["rest", "held"] * 3 + ["rest"]
    held = [phase for phase in phases if phase.kind == "held"]
    for phase, (start, end), angle in zip(held, holds, (1.0, -0.8, 0.9), strict=True):
        assert phase.start_s == pytest.approx(start, abs=0.2)
        assert phase.end_s == pytest.approx(end, abs=0.06)
        assert phase.level == pytest.approx(0.3 + angle, abs=5 * phase.level_stderr)


def test_level_stderr_is_honest():
    scores = []
    for seed in range(40):
        time, signal, _ = record(np.random.default_rng(seed), [(1.0, 2.0)])
        scores += [(p.level - 0.3) / p.level_stderr for p in stationary_phases(time, signal)[:1]]
    assert 0.7 < np.std(scores) < 1.35


def test_invalid_samples_during_the_tilt():
    time, signal, holds = record(np.random.default_rng(4), [(1.0, 2.0)])
    signal[(time > 2.3) & (time < 2.6)] = np.nan
    signal[::97] = np.nan  # and scattered dropouts all over
    phases = stationary_phases(time, signal)
    assert kinds(phases) == ["rest", "held", "rest"]
    assert phases[1].end_s == pytest.approx(holds[0][1], abs=0.06)


@pytest.mark.parametrize(
    "signal",
    [np.sin(np.arange(8000) / 50), np.full(8000, np.nan), np.arange(8000.0), np.zeros(1), np.zeros(20)],
)
def test_nothing_still(signal):
    assert stationary_phases(np.arange(signal.size) / RATE, signal) == []


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    st.lists(st.tuples(st.floats(0.3, 2.0), st.floats(0.8, 3.0)), min_size=1, max_size=4),
    st.floats(1e-5, 1e-2),
    st.floats(0.0, 0.15),
    st.integers(0, 1000),
)
def test_every_hold_is_found(releases, noise, overshoot, seed):
    time, signal, holds = record(np.random.default_rng(seed), releases, noise=noise, overshoot=overshoot)
    held = [phase for phase in stationary_phases(time, signal) if phase.kind == "held"]
    assert len(held) == len(holds)
    for phase, (_, release) in zip(held, holds, strict=True):
        assert phase.end_s == pytest.approx(release, abs=0.1)


@pytest.mark.parametrize("seed", [0, 1, 2, 3, 4, 10, 59])  # of the last two, 2 phases find less
def test_the_rest_of_an_oscillation_is_found_among_few_phases(seed, monkeypatch):
    """As among all, in records with one rest, up to six stops before a release, and a hand that catches."""
    draw, clock = np.random.default_rng(seed), np.arange(0, 4, 0.005)
    n, level, parts = int(draw.integers(2, 12)), 0.5, [np.full(200, 0.5)]
    for run in range(n):
        angle = draw.uniform(0.5, 1) * draw.choice([-1, 1])
        rest = [0.0] if run == n // 2 else []
        stops = [*rest, *(angle * np.sort(draw.uniform(0.1, 0.9, draw.integers(0, 7)))), angle]
        for stop in stops:
            parts.append(level + (stop - level) * smooth(clock[:300], 0, 0.5))
            level = stop
        parts.append(angle * swing(clock, draw.uniform(0.15, 0.3)))
        level = draw.uniform(-0.8, 0.8)
        parts.append(parts[-1][-1] + (level - parts[-1][-1]) * smooth(clock[:300], 0, 0.5))
    signal = np.concatenate(parts)
    signal += 0.3 + 1e-3 * draw.standard_normal(signal.size)
    found = []
    for around in (12, still_phases.AROUND, 10**6):
        monkeypatch.setattr(still_phases, "AROUND", around)
        found.append(kinds(stationary_phases(0.005 * np.arange(signal.size), signal)))
    assert found[0] == found[1] == found[2]
