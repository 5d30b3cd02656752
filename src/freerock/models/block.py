"""A rigid block on a flat base and the constants of its rocking motion."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from freerock.errors import FreerockError

GRAVITY = 9.81  # m/s², where none is stated
IMPOSSIBLE = 0.01, 1e7  # `density_if_square` of a block [kg/m³], beyond which a unit is wrong
POSITIVE = {"height_m": "metres", "width_m": "metres", "mass_kg": "kilograms", "contact_width_m": "metres"}
POSITIVE |= {"com_height_m": "metres", "inertia_kg_m2": "kg m²", "gravity_m_s2": "m/s²"}
SQUAT = math.radians(30)  # from this critical angle on a block may bounce, and then swing higher or longer


def density_if_square(height_m: float, width_m: float, mass_kg: float) -> float:
    """Density of a block, were it as deep as it is high [kg/m³]."""
    return mass_kg / (height_m**2 * width_m)


@dataclass(frozen=True)
class Block:
    """A rectangular block, uniform if nothing else is given (Spanos et al. 2017,
    doi:10.1016/j.proeng.2017.09.024).

    Parameters
    ----------
    height_m : float
        Full height 2h [m].
    width_m : float
        Full width 2b in the plane of rocking [m].
    mass_kg : float
        Mass m [kg].
    contact_width_m : float, optional
        Distance between the corners about which it rocks [m]; the full width if None.
        The inertia is that of the full width.
    edge_radius_m : float, optional
        Radius ρ of the edges of the base [m]; 0 of sharp ones.
    com_height_m : float, optional
        Height of the centre of mass over the base [m]; half the height if None.
    com_offset_m : float, optional
        Distance of the centre of mass to the right of the middle of the base [m]; 0 if None.
    inertia_kg_m2 : float, optional
        Moment of inertia about the centre of mass [kg m²]; that of the full uniform rectangle if None.
    gravity_m_s2 : float, optional
        Acceleration of gravity where it rocks [m/s²]; `GRAVITY` if None.

    Raises
    ------
    FreerockError
        A number that no block has.

    Examples
    --------
    >>> block = Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
    >>> print(f"{math.degrees(block.theta_cr):.3f}° {block.p:.3f} rad/s {block.restitution_housner:.4f}")
    14.036° 7.140 rad/s 0.9118
    """

    height_m: float
    width_m: float
    mass_kg: float
    contact_width_m: float | None = None
    edge_radius_m: float = 0.0
    com_height_m: float | None = None
    com_offset_m: float | None = None
    inertia_kg_m2: float | None = None
    gravity_m_s2: float | None = None

    def __post_init__(self) -> None:
        for name, unit in POSITIVE.items():
            value = getattr(self, name)
            if value is not None and not (hasattr(value, "__float__") and 0 < value < math.inf):
                raise FreerockError(name, f"{value!r} is not a positive number", f"give it in {unit}")
        density = density_if_square(self.height_m, self.width_m, self.mass_kg)
        if not IMPOSSIBLE[0] < density < IMPOSSIBLE[1]:
            what = f"as deep as it is high, the block would have {density:.3g} kg/m³"
            raise FreerockError("block", what, "give height_m and width_m in metres, mass_kg in kilograms")
        if not abs(self.e) < self.b / 3:
            what = f"{self.e:g} m off the middle, the block at rest stands on a part of its base"
            remedy = f"give less than {self.b / 3:g} m, a sixth of the width"
            raise FreerockError("com_offset_m", what, remedy)
        if not (hasattr(self.edge_radius_m, "__float__") and 0 <= self.edge_radius_m < self.b):
            what = f"{self.edge_radius_m} m is no radius of an edge"
            raise FreerockError("edge_radius_m", what, f"give 0 to {self.b:g} m, half the width")

    @cached_property
    def g(self) -> float:
        """Acceleration of gravity g [m/s²]."""
        return GRAVITY if self.gravity_m_s2 is None else self.gravity_m_s2

    @cached_property
    def weight(self) -> float:
        """Weight m g [N]."""
        return self.mass_kg * self.g

    @cached_property
    def h(self) -> float:
        """Height h of the centre of mass over the base, half the height of a uniform block [m]."""
        return self.height_m / 2 if self.com_height_m is None else self.com_height_m

    @cached_property
    def e(self) -> float:
        """Offset e of the centre of mass to the right of the middle of the base [m]."""
        return self.com_offset_m or 0.0

    @cached_property
    def b(self) -> float:
        """Half width b of the base [m]."""
        return (self.contact_width_m or self.width_m) / 2

    @cached_property
    def flat(self) -> float:
        """Half width b - ρ of the base between its edges [m]."""
        return self.b - self.edge_radius_m

    @cached_property
    def R(self) -> float:
        """Distance R of the nearer base corner from the centre of mass [m]."""
        return math.hypot(self.b - abs(self.e), self.h)

    @cached_property
    def theta_cr(self) -> float:
        """Critical tilt angle atan((b - |e|)/h) [rad]: beyond it the block overturns under its weight."""
        return self.corner(self.e)[0]

    @cached_property
    def p(self) -> float:
        """Frequency parameter sqrt(m g R / I_corner), sqrt(3g/4R) of a rectangle, nearer corner [rad/s].

        Housner 1963, doi:10.1785/BSSA0530020403.
        """
        return self.corner(self.e)[1]

    def corner(self, side: float) -> tuple[float, float]:
        """θ_cr [rad] and p [rad/s] about the corner on a side, 1 the right one, -1 the left one."""
        towards = self.e if side > 0 else -self.e
        arm = self.b - towards
        moment = self.weight * math.hypot(arm, self.h)
        return math.atan2(arm, self.h), math.sqrt(moment / self.inertia_corner(towards))

    @cached_property
    def inertia_cm(self) -> float:
        """Moment of inertia about the centre of mass [kg m²]."""
        if self.inertia_kg_m2 is not None:
            return self.inertia_kg_m2
        return self.mass_kg * (self.width_m**2 + self.height_m**2) / 12

    @cached_property
    def inertia_base(self) -> float:
        """Moment of inertia I_cm + m (h² + e²) about the base centre [kg m²], eq. (1b)."""
        return self.inertia_cm + self.mass_kg * (self.h**2 + self.e**2)

    def inertia_corner(self, towards: float) -> float:
        """Moment of inertia [kg m²] about a corner, the centre of mass nearer to it by `towards` [m]."""
        return self.inertia_base + self.mass_kg * (self.b**2 - 2 * self.b * towards)

    def com(self, s: float, cos: float) -> tuple[float, float]:
        """Centre of mass to the right of and above the base centre, at the sine and cosine of θ [m]."""
        return self.h * s + self.e * cos, self.h * cos - self.e * s

    def moved(self, by: Mapping[str, float]) -> "Block":
        """The block with some numbers larger by so much; one that is None starts from its default."""
        given = {name: getattr(self, name) for name in by}
        moved = replace(self, **{name: each + by[name] for name, each in given.items() if each is not None})
        if None not in given.values():
            return moved
        default = {"com_height_m": moved.h, "com_offset_m": 0.0, "inertia_kg_m2": moved.inertia_cm}
        default |= {"gravity_m_s2": moved.g}
        found = {name: default[name] + by[name] for name, each in given.items() if each is None}
        return replace(moved, **found)

    def as_found(self, values: Mapping[str, float]) -> "Block":
        """The block with the width and the edge radius [m] that a fit found, where it freed them."""
        if "width" not in values and "edge_radius" not in values:
            return self
        fields = {"width": "contact_width_m", "edge_radius": "edge_radius_m"}
        found = {field: float(values[name]) for name, field in fields.items() if name in values}
        known = all(getattr(self, field) == value for field, value in found.items())
        return self if known else replace(self, **found)

    @property
    def restitution_housner(self) -> float:
        """Restitution of a rigid block on a rigid base: 1 - 1.5 sin²θ_cr of a rectangle.

        Housner 1963, doi:10.1785/BSSA0530020403. It is of the corner farther from the centre of mass.
        """
        return 1 - 2 * self.mass_kg * (self.b**2 + self.b * abs(self.e)) / self.inertia_corner(-abs(self.e))
