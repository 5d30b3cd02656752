"""The power series of a scene's motion, and its regimes, for `taylor`.

The contact is the interval of the base in which two linear functions of u are positive: the depth and, under
the tensionless rule, the force over a positive factor (solutions/README.md). Nothing is shared with
`freerock.models`.
"""

from collections import defaultdict
from collections.abc import Callable
from fractions import Fraction
from math import isqrt

from freerock_bench.golden.fixed_point import ONE, PI, PLACES, UNIT, Series, fixed, product, quotient, sine
from freerock_bench.golden.scenes import PULSE_PERIOD_S, Scene

ORDER = 30
GRAVITY = Fraction("9.81")  # m/s²
REST, CORNER, DEPTH, PULL, AIR = "rest", "corner", "depth", "pull", "air"
Regime = tuple[object, ...]  # kinds of the two ends of the contact, and the side of the corner turned about


class Motion:
    """The series of a scene's motion and its regimes."""

    def __init__(self, scene: Scene) -> None:
        """Constants per unit mass, the static state at the release."""
        block, values = scene.block, scene.parameters
        mass = Fraction(str(block.mass_kg))
        b, h = Fraction(str(block.width_m)) / 2, Fraction(str(block.height_m)) / 2
        self.b, self.h, self.g = fixed(b), fixed(h), fixed(GRAVITY)
        self.slope = fixed(b / h)
        self.inertia = fixed((b * b + h * h) / 3)
        self.corner_inertia = fixed((b * b + h * h) * 4 / 3)
        self.rigid = scene.law == "housner"
        self.pivots = scene.kinematics == "pivoting"
        self.tensionless = scene.debonding == "tensionless"
        self.r = fixed(Fraction(str(values.get("r", 0))))
        self.k, self.c, self.lam = (
            fixed(Fraction(str(values.get(name, 0))) / mass) for name in ("k", "c", "lambda")
        )
        self.shake = tuple(fixed(Fraction(str(peak))) for peak in scene.pulse)
        self.omega = fixed(2 * PI / Fraction(str(PULSE_PERIOD_S)))
        self.shaken = False
        theta = fixed(scene.theta0)
        s, c = sine(theta)
        # z, ż, θ, θ̇, sin θ, cos θ, and sine and cosine of the pulse's phase
        drop = fixed(Fraction(str(scene.drop_m)))
        depth = 0 if self.rigid else self._static(abs(s))
        if drop:
            depth = -(self.b * abs(s) >> PLACES) - drop
        self.state = [depth, 0, theta, 0, s, c, 0, ONE]

    def _static(self, s: int) -> int:
        """Depth of the base centre at which the bed carries the weight."""
        flat = (self.g << PLACES) // (2 * self.b * self.k >> PLACES)
        reach = self.b * s >> PLACES
        if flat >= reach:
            return flat
        return isqrt((2 * self.g * s << PLACES) // self.k) - reach

    def regime(self, state: list[int]) -> Regime:
        """Of a state: the kinds of both ends of the contact, and the side of the corner turned about."""
        z, v, theta, w, s, c = state[:6]
        side = 0 if not self.pivots else 1 if theta >= 0 else -1
        if self.rigid:
            return (side,)
        conditions = [(DEPTH, z, s)]
        if self.tensionless:
            q = w * c >> PLACES
            conditions.append((PULL, *self._pull(z, v, s, q)))
        low, high, kinds = -self.b, self.b, [CORNER, CORNER]
        for kind, value, by_u in conditions:
            if by_u == 0:
                if value <= 0:
                    return (AIR, AIR, side)
                continue
            u = -(value << PLACES) // by_u
            if by_u > 0 and u > low:
                low, kinds[0] = u, kind
            elif by_u < 0 and u < high:
                high, kinds[1] = u, kind
        return (*kinds, side) if low < high else (AIR, AIR, side)

    def _pull(self, z: int, v: int, s: int, q: int) -> tuple[int, int]:
        """What has the sign of the force: its value at the base centre and its slope in u."""
        if self.c:
            return self.k * z + self.c * v >> PLACES, self.k * s + self.c * q >> PLACES
        return self.k + (self.lam * v >> PLACES), self.lam * q >> PLACES

    def series(self, regime: Regime) -> list[Series]:
        """Of the whole state, from now on, by the formulas of a regime."""
        y: list[Series] = [[value] for value in self.state]
        turn = self._turning(y, regime) if self.rigid else Bed(self, y, regime).accelerations
        for n in range(ORDER):
            down, around = turn(n)
            _, v, _, w, s, c, phase, cophase = y
            faster, slower = product(c, w, n), product(s, w, n)
            omega = self.omega if self.shaken else 0
            turning = omega * cophase[n] >> PLACES, -(omega * phase[n] >> PLACES)
            rates = (v[n], down, w[n], around, faster, -slower, *turning)
            for each, rate in zip(y, rates, strict=True):
                each.append((rate >> UNIT) // (n + 1))
        return y

    def _turning(self, y: list[Series], regime: Regime) -> Callable[[int], tuple[int, int]]:
        """θ̈ of Housner's block, coefficient by coefficient."""
        if regime == (REST,):
            return lambda n: (0, 0)
        _, _, _, _, s, c, phase, _ = y
        arm = self.b if regime[0] == 1 else -self.b
        x: Series = []
        gravity: Series = []
        lever: Series = []
        fall: Series = []

        def next_one(n: int) -> tuple[int, int]:
            self.ground(x, gravity, phase, n)
            lever.append(self.h * c[n] + arm * s[n] >> PLACES)
            fall.append(self.h * s[n] - arm * c[n] >> PLACES)
            moment = product(x, lever, n) + product(gravity, fall, n)
            return 0, (moment << PLACES) // self.corner_inertia

        return next_one

    def ground(self, x: Series, gravity: Series, phase: Series, n: int) -> None:
        """Add coefficient n of ẍ_g and of g + z̈_g."""
        moving = phase[n] if self.shaken else 0
        x.append(self.shake[0] * moving >> PLACES)
        gravity.append((self.g if n == 0 else 0) + (self.shake[1] * moving >> PLACES))

    def lifted(self, state: list[int]) -> Regime:
        """Of Housner's block at rest: still so, or the side of the corner about which the ground turns it."""
        phase = state[6] if self.shaken else 0
        x = self.shake[0] * phase >> PLACES
        gravity = self.g + (self.shake[1] * phase >> PLACES)
        if abs(x) <= gravity * self.slope >> PLACES:
            return (REST,)
        return (1,) if x > 0 else (-1,)


class Bed:
    """z̈_cb and θ̈ of a block on its bed by the formulas of a regime, coefficient by coefficient."""

    def __init__(self, motion: Motion, y: list[Series], regime: Regime) -> None:
        """The series of the state, which grow, and those that follow from it."""
        self.motion, self.y = motion, y
        self.lower, self.upper, side = regime
        self.arm = motion.b * int(str(side))
        self.of: dict[str, Series] = defaultdict(list)

    def accelerations(self, n: int) -> tuple[int, int]:
        """Coefficient n of z̈_cb and of θ̈, after all lower ones."""
        of, bed = self.of, self.motion
        z, v, _, w, s, c, phase, _ = self.y
        of["q"].append(product(w, c, n))
        of["zv"].append(product(z, v, n))
        of["sv_zq"].append(product(s, v, n) + product(z, of["q"], n))
        of["sq"].append(product(s, of["q"], n))
        if self.lower == AIR:
            of["force"].append(0)
            of["moment"].append(0)
        else:
            self._push(n)
        bed.ground(of["x"], of["gravity"], phase, n)
        of["ww"].append(product(w, w, n))
        of["lever"].append(bed.h * c[n] + self.arm * s[n] >> PLACES)
        of["bend"].append(self.arm * c[n] - bed.h * s[n] >> PLACES)
        of["drive"].append(of["x"][n] - product(of["bend"], of["ww"], n))
        of["hs"].append(bed.h * s[n] >> PLACES)
        of["hc"].append(bed.h * c[n] >> PLACES)
        turning = product(of["lever"], of["drive"], n) + product(of["hs"], of["force"], n)
        of["turning"].append(turning - product(c, of["moment"], n))
        of["inertia"].append((bed.inertia if n == 0 else 0) + product(of["lever"], of["lever"], n))
        of["around"].append(quotient(of["turning"], of["inertia"], of["around"], n))
        down = of["gravity"][n] - of["force"][n] - product(of["hc"], of["ww"], n)
        return down - product(of["hs"], of["around"], n), of["around"][n]

    def _push(self, n: int) -> None:
        """Force and moment over cos θ: moments of f0 + f1 u + f2 u² over the contact [u0, u1]."""
        of, bed = self.of, self.motion
        z, v, s = self.y[0], self.y[1], self.y[4]
        of["f0"].append(bed.k * z[n] + bed.c * v[n] + bed.lam * of["zv"][n] >> PLACES)
        of["f1"].append(bed.k * s[n] + bed.c * of["q"][n] + bed.lam * of["sv_zq"][n] >> PLACES)
        of["f2"].append(bed.lam * of["sq"][n] >> PLACES)
        if bed.c:
            of["pull"].append(bed.k * z[n] + bed.c * v[n] >> PLACES)
            of["by_u"].append(bed.k * s[n] + bed.c * of["q"][n] >> PLACES)
        else:
            of["pull"].append((bed.k if n == 0 else 0) + (bed.lam * v[n] >> PLACES))
            of["by_u"].append(bed.lam * of["q"][n] >> PLACES)
        u0, u1 = of["u0"], of["u1"]
        self._end(self.lower, u0, -bed.b, n)
        self._end(self.upper, u1, bed.b, n)
        of["length"].append(u1[n] - u0[n])
        of["sum"].append(u1[n] + u0[n])
        both, square = product(u0, u1, n), product(of["sum"], of["sum"], n)
        of["for2"].append(square - both)
        of["for3"].append(square - 2 * both)
        of["first"].append(product(of["length"], of["sum"], n) // 2)
        of["second"].append(product(of["length"], of["for2"], n) // 3)
        of["third"].append(product(of["first"], of["for3"], n) // 2)
        moments = (of["length"], of["first"], of["second"], of["third"])
        f = (of["f0"], of["f1"], of["f2"])
        of["force"].append(sum(product(a, b, n) for a, b in zip(f, moments[:3], strict=True)))
        of["moment"].append(sum(product(a, b, n) for a, b in zip(f, moments[1:], strict=True)))

    def _end(self, kind: object, u: Series, corner: int, n: int) -> None:
        """Coefficient n of an end of the contact: a corner, or the zero of a function linear in u."""
        if kind == CORNER:
            u.append(corner if n == 0 else 0)
            return
        value, slope = (self.y[0], self.y[4]) if kind == DEPTH else (self.of["pull"], self.of["by_u"])
        u.append(-quotient(value, slope, [-each for each in u], n))
