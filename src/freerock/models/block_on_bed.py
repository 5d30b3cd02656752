"""Returns the state of a block on a bed: how deep it sinks, how it leans, its energy."""

import math
from typing import NamedTuple

import numpy as np

from freerock.arrays import Floats
from freerock.models import kernel
from freerock.models.block import Block
from freerock.models.laws import GEOMETRIC, Foundation, Rules


class State(NamedTuple):
    """State of the block.

    Parameters
    ----------
    z, z_rate : float
        Depth of the base centre, positive downward [m], and its rate [m/s].
    theta, theta_rate : float
        Rotation, positive clockwise [rad], and its rate [rad/s].
    """

    z: float
    z_rate: float
    theta: float
    theta_rate: float


def static_depth(block: Block, foundation: Foundation, theta: float) -> float:
    """Depth z_cb [m] at which the foundation carries the block's weight at rotation theta [rad]."""
    return float(kernel.depth_at_rest(abs(math.sin(theta)), foundation.constants(block))[0])


def lean(block: Block, foundation: Foundation, tilt_rad: float) -> float:
    """Angle to the base [rad] at which a block at rest stands on one that is off level by τ, positive to the
    right.

    The linearised no-uplift equation (1) of Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024) at rest:
    m g (h sin τ + e cos τ) / (2/3 b³ k - m g (h cos τ - e sin τ)).
    """
    s, cos, weight = math.sin(tilt_rad), math.cos(tilt_rad), block.weight
    turning, falling = weight * block.h * s, weight * block.h * cos
    turning, falling = turning + weight * block.e * cos, falling - weight * block.e * s
    return turning / (2 / 3 * block.b**3 * foundation.k - falling)


def energy(
    block: Block,
    foundation: Foundation,
    z_cb: float | Floats,
    z_cb_rate: float | Floats,
    theta: float | Floats,
    theta_rate: float | Floats,
    rules: Rules = GEOMETRIC,
) -> Floats:
    """Mechanical energy [J] above the upright block, sunk by its weight, for arrays or floats.

    The sum of kinetic energy, weight and elastic energy ∫ k z²/2 du over the contact z > 0.

    Parameters
    ----------
    block : Block
    foundation : Foundation
    z_cb, z_cb_rate, theta, theta_rate : float or ndarray, shape (n_time,)
        State [m, m/s, rad, rad/s].
    rules : Rules
        Its kinematics.
    """
    m, h, law, s = block.mass_kg, block.h, foundation.constants(block), np.sin(theta)
    along, above = h * s + block.e * np.cos(theta), h * np.cos(theta) - block.e * s
    lever = above + (block.flat * np.abs(s) if rules.kinematics == "pivoting" else 0.0)
    sinking = z_cb_rate + along * theta_rate
    kinetic = 0.5 * m * ((lever * theta_rate) ** 2 + sinking**2) + 0.5 * block.inertia_cm * theta_rate**2
    at_rest = static_depth(block, foundation, 0.0)
    weight = block.weight * (-2 * h * np.sin(0.5 * theta) ** 2 - block.e * s - (z_cb - at_rest))
    elastic = np.vectorize(lambda z, s: kernel.stored(z, s, law), [float])(z_cb, s)
    return np.asarray(kinetic + weight + m * (elastic - kernel.stored(at_rest, 0.0, law)))
