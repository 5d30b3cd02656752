"""Free rocking of Housner's block from rest, in closed form.

A rigid block turns about its corners; an impact multiplies its angular rate by r (Housner 1963,
doi:10.1785/BSSA0530020403). With φ = θ_cr - |θ|, φ̈ = p² sinφ between impacts: a pendulum turned upside
down, whose energy E = sin²(φ/2) + (its kinetic part) decides the swing. From a peak,

    sin(φ/2) = k' / dn(p (t - t_peak) | 1 - k'²),    k' = sin(φ_peak/2),

an impact happens at φ = θ_cr, and sin²(θ_cr/2) - k'² is multiplied by r² there. The block comes to rest
after infinitely many impacts in finite time. A block that is pushed or thrown is integrated by `kernel`.
Elliptic integrals are Carlson's; dn and sn/dn are
quotients of theta functions of the complementary nome exp(-π K/K') (DLMF 20.7.30-33, 22.2.4-22.2.9),
of which four terms give every digit.
"""

import math
from dataclasses import dataclass

import numpy as np

from freerock.arrays import Floats
from freerock.models.block import Block
from freerock.models.compiled import compiled

# Amplitude below which the remaining impacts are summed as a geometric series [rad].
REST_AMPLITUDE = 1e-13
Polynomial = tuple[float, float, float, float, float]
# Largest argument of cosh and of the arc sine of which sums of 14 powers of its square have all digits, and
# the factors of these in cosh x, sinh x / x and asin x / x.
SHORT, SLENDER = 2.0, 0.25
C = tuple(1 / math.factorial(2 * i) for i in range(14))
S = tuple(1 / math.factorial(2 * i + 1) for i in range(14))
A = tuple(math.comb(2 * i, i) * 0.25**i / (2 * i + 1) for i in range(14))


@dataclass(frozen=True)
class Swings:
    """The free motion of Housner's block between impacts, one entry per swing.

    Parameters
    ----------
    block : Block
        The block.
    sign : ndarray, shape (n_swings,)
        Sign of θ.
    k2 : ndarray, shape (n_swings,)
        k'² = sin²(φ_peak/2).
    energy : ndarray, shape (n_swings,)
        sin²(θ_cr/2) - k'², which is (θ̇/2p)² at the impact.
    peak_time : ndarray, shape (n_swings,)
        Instant of the peak [s].
    impact_time : ndarray, shape (n_swings,)
        Instant of the impact that ends the swing [s].
    rest_time : float
        Instant after which the block is at rest [s]; inf if the swings end before it.
    outcome : str
        "completed", "overturned" (after the last swing) or "step_limit".
    """

    block: Block
    sign: Floats
    k2: Floats
    energy: Floats
    peak_time: Floats
    impact_time: Floats
    rest_time: float
    outcome: str

    @property
    def peak(self) -> Floats:
        """|θ| at the peak of each swing, shape (n_swings,) [rad]."""
        s, c = math.sin(self.block.theta_cr / 2), math.cos(self.block.theta_cr / 2)
        return np.asarray(2 * np.arcsin(self.energy / (s * np.sqrt(1 - self.k2) + c * np.sqrt(self.k2))))

    @property
    def impact_rate(self) -> Floats:
        """|θ̇| just before the impact of each swing, shape (n_swings,) [rad/s]."""
        return np.asarray(2 * self.block.p * np.sqrt(self.energy))


def housner_swings(
    block: Block,
    r: float | Floats,
    theta0: float,
    until: float = math.inf,
    max_impacts: int = 1_000_000,
) -> Swings:
    """Impacts and peaks of a block released from rest, up to an instant or until it rests again.

    Parameters
    ----------
    block : Block
        The block.
    r : float or ndarray, shape (n_impacts,)
        Restitution, 0 <= r <= 1: ratio of angular rates after and before an impact; or that of each of the
        first impacts, the last one being that of all further ones.
    theta0 : float
        Rotation at t = 0 [rad].
    until : float
        Instant up to which swings are wanted [s].
    max_impacts : int
        Impacts after which to give up.

    Returns
    -------
    Swings
    """
    s2, phi0 = math.sin(block.theta_cr / 2) ** 2, block.theta_cr - abs(theta0)
    if theta0 == 0 or phi0 <= 0:
        none: Floats = np.empty(0)
        rest_time, outcome = (0.0, "completed") if theta0 == 0 else (math.inf, "overturned")
        return Swings(block, none, none, none, none, none, rest_time, outcome)
    # sin²(θ_cr/2) - sin²(φ0/2), without cancellation
    energy = math.sin(abs(theta0) / 2) * math.sin(block.theta_cr - abs(theta0) / 2)
    kept: Floats = np.ones(1)  # shares of the energy
    if np.ndim(r):
        kept = np.cumprod(np.append(1.0, np.asarray(r, dtype=float)[:-1])) ** 2
        r = r[-1]  # type: ignore[index]
    r = float(r)
    # impacts after which the rest of them is summed; none without losses
    n_rest, rest_energy = math.inf if r >= 1 else len(kept), 0.5 * REST_AMPLITUDE * math.sin(block.theta_cr)
    if 0 < r < 1 and kept[-1] * energy > rest_energy:
        n_rest += math.ceil(0.5 * math.log(rest_energy / (kept[-1] * energy)) / math.log(r))
    first = math.copysign(1.0, theta0), math.sin(phi0 / 2) ** 2, energy
    sign, k2, energies, peak_time, impact_time = _find_swings(
        first, s2, block.p, kept, r, float(until), float(min(n_rest, max_impacts))
    )
    outcome = "completed"
    if impact_time[-1] < until and len(k2) < n_rest:
        outcome = "step_limit" if len(k2) >= max_impacts else "overturned"
    rest_time = math.inf
    if len(k2) == n_rest:
        # the durations fall by r from swing to swing
        last = 2 * float(impact_time[-1] - peak_time[-1]) if len(k2) > 1 else 0.0
        rest_time = float(impact_time[-1]) + last * r / (1 - r)
    return Swings(block, sign, k2, energies, peak_time, impact_time, rest_time, outcome)


@compiled()
def _carlson(x: float, y: float, z: float) -> float:
    """Carlson's elliptic integral R_F by duplication (DLMF 19.36.1), to the last digits; NaN of no number."""
    while True:
        mean = (x + y + z) / 3
        if math.isnan(mean):
            return mean
        a, b = 1 - x / mean, 1 - y / mean
        c = -a - b
        if max(abs(a), abs(b), abs(c)) < 2e-3:
            e2, e3 = a * b - c * c, a * b * c
            series = 1 - e2 / 10 + e3 / 14 + e2 * e2 / 24 - 3 * e2 * e3 / 44
            return (series - 5 * e2**3 / 208 + 3 * e3 * e3 / 104) / math.sqrt(mean)
        root = math.sqrt(x * y) + math.sqrt(y * z) + math.sqrt(z * x)
        x, y, z = 0.25 * (x + root), 0.25 * (y + root), 0.25 * (z + root)


@compiled()
def _from_peak(k2: float, energy: float, s2: float) -> float:
    """p times the time from a peak to the impact, s2 = sin²(θ_cr/2)."""
    m = 1 - k2
    return math.sqrt(energy / (s2 * m)) * _carlson(k2 * (1 - s2) / (s2 * m), k2 / s2, 1.0)


@compiled()
def _find_swings(
    first: tuple[float, float, float],
    s2: float,
    p: float,
    kept: Floats,
    r: float,
    until: float,
    most: float,
) -> Floats:
    """Sign, k'², energy, peak and impact time of the swings, shape (5, n_swings), until one overturns."""
    table = np.empty((5, 64))
    table[0, 0], table[1, 0], table[2, 0] = first
    table[3, 0], table[4, 0] = 0.0, _from_peak(first[1], first[2], s2) / p
    n = 1
    while table[4, n - 1] < until and n < most:
        own = min(n, kept.size - 1)
        energy = first[2] * kept[own] * r ** (2.0 * (n - own))
        if energy >= s2:
            break
        if n == table.shape[1]:
            longer = np.empty((5, 2 * n))
            longer[:, :n] = table
            table = longer
        half = _from_peak(s2 - energy, energy, s2) / p
        table[0, n], table[1, n], table[2, n] = -table[0, n - 1], s2 - energy, energy
        table[3, n] = table[4, n - 1] + half
        table[4, n] = table[4, n - 1] + 2 * half
        n += 1
    return table[:, :n]


def housner_motion(swings: Swings, time: Floats, theta0: float, rates: bool = True) -> tuple[Floats, Floats]:
    """Rotation and angular rate of the closed form.

    Parameters
    ----------
    swings : Swings
        From `housner_swings`, for the same start.
    time : ndarray, shape (n_time,)
        Increasing instants [s]; the block is held up to t = 0.
    theta0 : float
        Rotation at the release [rad].
    rates : bool
        Whether angular rates are wanted.

    Returns
    -------
    theta : ndarray, shape (n_time,)
        [rad]; NaN after the last swing of a block that overturns or of an incomplete sequence.
    theta_rate : ndarray, shape (n_time,)
        [rad/s]; empty where it is not wanted.
    """
    p, theta_cr = swings.block.p, swings.block.theta_cr
    after = 0.0 if swings.outcome == "completed" else math.nan
    time = np.ascontiguousarray(time, dtype=float)
    theta = np.empty(time.shape)
    theta_rate = np.empty(time.shape if rates else 0)
    held = int(np.searchsorted(time, 0.0, side="right"))
    theta[:held], theta_rate[:held] = theta0, 0.0
    known = swings.sign, swings.k2, swings.peak_time, swings.impact_time
    _fill_motion(*known, p, theta_cr, after, held, time, theta, theta_rate)
    return theta, theta_rate


@compiled()
def _theta_functions(k2: float) -> tuple[float, float, float, Polynomial, Polynomial, Polynomial]:
    """What a swing from k'² on is made of: the scale of the argument, the factors of cosh and of sinh, and
    the even, the odd and the alternating theta function of imaginary argument i x as polynomials in cosh 2x.
    """
    m = 1 - k2
    k_quarter, k_complement = _carlson(0.0, k2, 1.0), _carlson(0.0, m, 1.0)
    q = math.exp(-math.pi * k_quarter / k_complement)
    q2, q4, q6, q9, q12, q16 = q**2, q**4, q**6, q**9, q**12, q**16
    scale = math.pi / (2 * k_complement)
    even = (1 - 2 * q4 + 2 * q16, 2 * q - 6 * q9, 4 * q4 - 16 * q16, 8 * q9, 16 * q16)
    odd = (1 - q2 - q6 + q12, 2 * q2 - 2 * q6 - 4 * q12, 4 * q6 - 4 * q12, 8 * q12, 0.0)
    other = (odd[0], -2 * q2 + 2 * q6 + 4 * q12, odd[2], -odd[3], 0.0)
    of_even = even[0] + even[1] + even[2] + even[3] + even[4]
    of_cosh = math.sqrt(k2) * of_even / (odd[0] + odd[1] + odd[2] + odd[3])
    of_sinh = math.sqrt(k2 * m) * of_even / (other[0] + other[1] + other[2] + other[3]) / scale
    return scale, of_cosh, of_sinh, even, odd, other


@compiled(forceinline=True)
def _sum_of_powers(q: float, factors: tuple[float, ...]) -> float:
    """Sum of 14 powers of q by their factors."""
    f, r = factors, q * q
    low = (1 + q * f[1]) + r * ((f[2] + q * f[3]) + r * ((f[4] + q * f[5]) + r * (f[6] + q * f[7])))
    high = (f[8] + q * f[9]) + r * ((f[10] + q * f[11]) + r * (f[12] + q * f[13]))
    return low + (r * r) * (r * r) * high


@compiled()
def _fill_swing(
    shape: tuple[float, float, float, Polynomial, Polynomial, Polynomial],
    side: float,
    peak_time: float,
    p: float,
    theta_cr: float,
    begin: int,
    end: int,
    time: Floats,
    theta: Floats,
    theta_rate: Floats,
) -> None:
    """Fill θ, and θ̇ where wanted, of one swing.

    Of a block as slender and a swing as short as most are, in sums of powers: without branches, several
    samples are computed in one.
    """
    scale, of_cosh, of_sinh, v, u, w = shape
    rate, of_rate = p * scale, -2 * side * p * of_sinh
    short = rate * max(peak_time - time[begin], time[end - 1] - peak_time) < SHORT
    if short and math.sin(0.5 * theta_cr) < SLENDER:
        # of an unsigned index numba need not ask whether it counts from the end
        for i in range(np.uint64(begin), np.uint64(end)):
            x = rate * (time[i] - peak_time)
            cosh = _sum_of_powers(x * x, C)
            c = 2 * cosh * cosh - 1
            even = v[0] + c * (v[1] + c * (v[2] + c * (v[3] + c * v[4])))
            odd = u[0] + c * (u[1] + c * (u[2] + c * u[3]))
            sine = of_cosh * cosh * odd / even
            theta[i] = side * (theta_cr - 2 * sine * _sum_of_powers(sine * sine, A))
        if theta_rate.size:
            for i in range(np.uint64(begin), np.uint64(end)):
                x = rate * (time[i] - peak_time)
                q = x * x
                cosh = _sum_of_powers(q, C)
                c = 2 * cosh * cosh - 1
                even = v[0] + c * (v[1] + c * (v[2] + c * (v[3] + c * v[4])))
                other = w[0] + c * (w[1] + c * (w[2] + c * w[3]))
                theta_rate[i] = of_rate * x * _sum_of_powers(q, S) * other / even
        return
    for i in range(np.uint64(begin), np.uint64(end)):
        e = math.exp(rate * (time[i] - peak_time))
        cosh = 0.5 * (e + 1 / e)
        c = 2 * cosh * cosh - 1
        even = v[0] + c * (v[1] + c * (v[2] + c * (v[3] + c * v[4])))
        odd = u[0] + c * (u[1] + c * (u[2] + c * u[3]))
        theta[i] = side * (theta_cr - 2 * math.asin(of_cosh * cosh * odd / even))
        if theta_rate.size:
            other = w[0] + c * (w[1] + c * (w[2] + c * w[3]))
            theta_rate[i] = of_rate * 0.5 * (e - 1 / e) * other / even


@compiled()
def _fill_motion(
    sign: Floats,
    k2: Floats,
    peak_time: Floats,
    impact_time: Floats,
    p: float,
    theta_cr: float,
    after: float,
    begin: int,
    time: Floats,
    theta: Floats,
    theta_rate: Floats,
) -> None:
    """Fill θ from a sample on, and θ̇ where wanted; what comes after the last swing is `after`."""
    for i in range(k2.size):
        end, beyond = begin, time.size
        while end < beyond:  # samples up to the impact
            middle = (end + beyond) // 2
            if time[middle] <= impact_time[i]:
                end = middle + 1
            else:
                beyond = middle
        if end > begin:
            shape = _theta_functions(k2[i])
            _fill_swing(shape, sign[i], peak_time[i], p, theta_cr, begin, end, time, theta, theta_rate)
            begin = end
    theta[begin:] = after
    theta_rate[begin:] = after
