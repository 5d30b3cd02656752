"""AC coupling: a channel in which every constant reading decays."""

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from freerock.arrays import Floats, Mask

BLOCK_S = 0.025  # the signal is looked at in means over this long
WIDE = 10  # such means in the window that must stand still
RATES_TRIED = 40  # rates of decay that are tried


def ac_cutoff(step: float, signal: Floats) -> float | None:
    """Cut-off frequency [Hz] of an AC-coupled channel, None where a held angle stands still.

    Behind a first-order high pass of rate λ, whatever stands still decays: y' = -λ (y - y₀). The rates of
    decay of short windows of the signal are gathered; those that occur most are tried. With the right one
    x = y + λ ∫ (y - y₀) dt, the signal before the high pass, stands still clearly longer than y does, and
    comes back to the level it began at; a hand that creeps makes the former true, not the latter.

    Parameters
    ----------
    step : float
        Sampling interval [s].
    signal : ndarray, shape (n_time,)
        As recorded; NaN where it is not a number.

    Returns
    -------
    float or None
    """
    course = _course(step, signal)
    if course is None:
        return None
    y, limit = course
    dt = max(1, round(BLOCK_S / step)) * step
    at_first = _still(y, limit)
    if not at_first.any():
        return None
    first = int(np.argmax(at_first))
    y0 = float(y[first : first + WIDE].mean())
    area = (np.cumsum(y - y0) - (y - y0) / 2) * dt
    turned = np.abs(sliding_window_view(y, WIDE).mean(axis=1) - y0) > 0.02 * float(np.ptp(y))
    best = _rate(y, area, turned, limit)
    if best is None:
        return None
    x = y + best * area
    now = _still(x, limit)
    gained = np.count_nonzero(now & turned) - np.count_nonzero(at_first & turned)
    last = y.size - WIDE - int(np.argmax(now[::-1]))
    begin, end = x[first : first + WIDE].mean(), x[last : last + WIDE].mean()
    moved = np.abs(y[first:last] - y0).sum() * dt * best
    returned = moved > 0 and abs(end - begin) < 0.2 * moved
    return best / (2 * math.pi) if best > 0 and gained >= WIDE and returned else None


def _course(step: float, signal: Floats) -> tuple[Floats, float] | None:
    """The signal in means over `BLOCK_S` and the limit of stillness; None if it is too short or constant."""
    size = max(1, round(BLOCK_S / step))
    n = signal.size // size
    if n < 8 * WIDE:
        return None
    blocks = signal[: n * size].reshape(n, size)
    with np.errstate(invalid="ignore", over="ignore"):
        y = blocks.mean(axis=1)
        scatter = np.std(blocks[:: max(1, n // 2000)], axis=1)
    good = np.isfinite(y)
    if good.sum() < 8 * WIDE or not np.isfinite(scatter).any():
        return None
    y = np.interp(np.arange(n), np.flatnonzero(good), y[good])
    span = float(np.ptp(y))
    limit = max(float(np.nanpercentile(scatter, 5)), 5e-4 * span)
    return (y, limit) if 0 < span < 1e100 else None


def _still(x: Floats, limit: float) -> Mask:
    """Whether each window of `WIDE` means stands still."""
    ones = np.ones(WIDE) / WIDE
    x = x - x.mean()
    mean, square = np.convolve(x, ones, "valid"), np.convolve(x * x, ones, "valid")
    return np.asarray(square - mean**2 <= limit**2)


def _rate(y: Floats, area: Floats, turned: Mask, limit: float) -> float | None:
    """The rate λ [1/s] with which y + λ area stands still longest away from rest, None where none agree."""
    y_parts, areas = (sliding_window_view(each, WIDE)[turned] for each in (y, area))
    areas = areas - areas.mean(axis=1, keepdims=True)
    together, alone = (y_parts * areas).sum(axis=1), (areas**2).sum(axis=1)  # where y + λ area is constant
    with np.errstate(divide="ignore", invalid="ignore"):
        rates = np.sort(-together / alone)
    rates = rates[(rates > 0.01) & (rates < 20)]
    if rates.size < WIDE:
        return None
    density = np.log(rates[WIDE - 1 :] / rates[: 1 - WIDE])  # small where many windows agree
    candidates = rates[np.argsort(density)[:: WIDE // 2][:RATES_TRIED] + WIDE // 2]

    def stillness(rate: float) -> int:
        return int(np.count_nonzero(_still(y + rate * area, limit) & turned))

    best: float = max(candidates.tolist(), key=stillness)
    for _ in range(3):
        used = _still(y + best * area, limit)[turned]
        if not used.any():
            return None
        best = float(-together[used].sum() / alone[used].sum())
    return best
