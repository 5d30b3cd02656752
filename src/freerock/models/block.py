"""A rigid rectangular block and the constants of its rocking motion."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

GRAVITY = 9.81  # m/s²


@dataclass(frozen=True)
class Block:
    """A uniform rectangular block (Spanos et al. 2017, section 2, doi:10.1016/j.proeng.2017.09.024).

    Parameters
    ----------
    height_m : float
        Full height 2h [m].
    width_m : float
        Full width 2b in the plane of rocking [m].
    mass_kg : float
        Mass m [kg].
    contact_width_m : float, optional
        Distance of the corners it rocks about [m] where they are worn or rounded; the full width if None.
        The inertia is that of the full width.
    edge_radius_m : float, optional
        Radius ρ of the edges of the base [m]; sharp if None.

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
    edge_radius_m: float | None = None

    @cached_property
    def h(self) -> float:
        """Half height h [m]."""
        return self.height_m / 2

    @cached_property
    def b(self) -> float:
        """Half width b of the base [m]."""
        return (self.contact_width_m or self.width_m) / 2

    @cached_property
    def edge_radius(self) -> float:
        """Radius ρ of the edges of the base, 0 of sharp ones [m]."""
        return self.edge_radius_m or 0.0

    @cached_property
    def flat(self) -> float:
        """Half width b - ρ of the base between its edges [m]."""
        return self.b - self.edge_radius

    @cached_property
    def R(self) -> float:
        """Distance R of a base corner from the centre of mass [m]."""
        return math.hypot(self.b, self.h)

    @cached_property
    def theta_cr(self) -> float:
        """Critical tilt angle atan(b/h) [rad]: beyond it the block overturns under its weight."""
        return math.atan2(self.b, self.h)

    @cached_property
    def p(self) -> float:
        """Frequency parameter sqrt(m g R / I_corner), sqrt(3g/4R) of a rectangle [rad/s].

        Housner 1963, doi:10.1785/BSSA0530020403.
        """
        return math.sqrt(self.mass_kg * GRAVITY * self.R / (self.inertia_base + self.mass_kg * self.b**2))

    @cached_property
    def inertia_cm(self) -> float:
        """Moment of inertia about the centre of mass [kg m²]."""
        return self.mass_kg * (self.width_m**2 + self.height_m**2) / 12

    @cached_property
    def inertia_base(self) -> float:
        """Moment of inertia I_cm + m h² about the base centre [kg m²], eq. (1b)."""
        return self.inertia_cm + self.mass_kg * self.h**2

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

        Housner 1963, doi:10.1785/BSSA0530020403.
        """
        return 1 - 2 * self.mass_kg * self.b**2 / (self.inertia_base + self.mass_kg * self.b**2)
