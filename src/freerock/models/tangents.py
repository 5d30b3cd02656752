"""Derivatives of a free motion by the rate after each of its impacts, swing by swing.

A motion after an impact knows no more of what was before than its state there, z_cb, ż_cb and θ̇ at θ = 0, and
the instant. So each swing is taken again with each of the three a little larger: that gives the swing by its
own state, and the state and the instant of the next impact, whose derivatives follow by the chain rule.
"""

from dataclasses import dataclass

import numpy as np

from freerock.arrays import Floats, Indices
from freerock.models.compiled import compiled
from freerock.models.series import STIFF, rock

LATER_S = 1e-5  # after the next impact, up to which a swing is taken


@dataclass(frozen=True, eq=False)
class Tangents:
    """A motion swing by swing, from impact to impact.

    Parameters
    ----------
    begin : ndarray of int, shape (n_swings + 1,)
        First sample after each impact; at last the number of samples.
    by_state : ndarray, shape (2, 3, n_time)
        Derivatives of θ and z_cb by z_cb, ż_cb and θ̇ at the impact before, its instant kept.
    onward : ndarray, shape (n_swings, 4, 3)
        Derivatives of z_cb, ż_cb, θ̇ and instant of the next impact by these three.
    rates, factors : ndarray, shape (n_swings,)
        θ̇ after each impact, and by what it was multiplied there.
    """

    begin: Indices
    by_state: Floats
    onward: Floats
    rates: Floats
    factors: Floats

    def by_rates(self, by_theta: Floats, by_z: Floats, rate: Floats, out: Floats) -> None:
        """Fill the derivatives by the logarithm of the rate after each impact, the other rates held.

        Of what is seen, shape (n_time, n_impacts), and below of δ of each impact, (n_impacts, n_impacts).

        Parameters
        ----------
        by_theta, by_z : ndarray, shape (n_time,)
            Derivatives of what is seen by θ and by z_cb.
        rate : ndarray, shape (n_time,)
            Rate of what is seen.
        out : ndarray
            By columns; of zeros.
        """
        seen = np.nan_to_num(by_theta * self.by_state[0] + by_z * self.by_state[1])
        _chain(self.begin, seen, self.onward, self.rates, self.factors, np.nan_to_num(rate), out.T)


@compiled()
def _chain(begin, seen, onward, rates, factors, rate, out):
    for i in range(rates.size):
        z, v, w, late = 0.0, 0.0, rates[i], 0.0
        out[i, rate.size + i] = factors[i]
        for j in range(i, rates.size):
            for n in range(begin[j], begin[j + 1]):
                out[i, n] = z * seen[0, n] + v * seen[1, n] + w * seen[2, n] - late * rate[n]
            if j + 1 == rates.size:
                break
            by = onward[j]
            late += by[3, 0] * z + by[3, 1] * v + by[3, 2] * w
            before = by[2, 0] * z + by[2, 1] * v + by[2, 2] * w  # times the next factor
            out[i, rate.size + j + 1] = -factors[j + 1] * before / rates[j + 1]
            z, v = (
                by[0, 0] * z + by[0, 1] * v + by[0, 2] * w,
                by[1, 0] * z + by[1, 1] * v + by[1, 2] * w,
            )
            w = 0.0


@compiled()
def swings_by_series(
    scene, time, accuracy, factors, passages, depth, step, theta, z_cb, begin, by_state, onward
):
    """Fill `by_state` and `onward`; whether the law was nowhere stiff."""
    law, corner = scene
    tolerance, allowed, max_steps = accuracy
    own, n_swings = np.empty((1, 5)), begin.size - 1
    for j in range(n_swings):
        clock, z, v, _, w = passages[j]
        first, n = begin[j], begin[j + 1] - begin[j]
        is_last = j == n_swings - 1
        later = np.empty(n if is_last else n + 1)
        later[:n] = time[first : first + n] - clock
        if not is_last:
            later[n] = passages[j + 1, 0] - clock + LATER_S
        moved, rates = np.empty(later.size), np.empty((later.size, 3))
        for q in range(3):
            by = step * (max(abs(z), depth), law[3] * abs(w), abs(w))[q]
            state = z + by * (q == 0), v + by * (q == 1), 0.0, w + by * (q == 2)
            own[:] = np.nan
            known = tolerance, allowed, max_steps, factors[j + 1 : j + 2]
            if rock(law, corner, state, later, *known, own, moved, rates)[0] == STIFF:
                return False
            for i in range(n):
                by_state[0, q, first + i] = (moved[i] - theta[first + i]) / by
                by_state[1, q, first + i] = (rates[i, 0] - z_cb[first + i]) / by
            if not is_last:
                onward[j, 0, q] = (own[0, 1] - passages[j + 1, 1]) / by
                onward[j, 1, q] = (own[0, 2] - passages[j + 1, 2]) / by
                onward[j, 2, q] = (own[0, 4] - passages[j + 1, 4]) / by
                onward[j, 3, q] = (own[0, 0] - (passages[j + 1, 0] - clock)) / by
    return True
