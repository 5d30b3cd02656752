"""Where a beam meets the block: displacement of the target from rotation, and back.

Kinematics: the block pivots, it turns as a rigid body about the corner that is down, and that corner does not
slide. (A guided base centre leaves the face b(1 - cos θ) behind: docs/equations.md, section 8.) Nor does it
sink, where rotation is found from displacement: no single beam knows how deep it lies.
"""

import numpy as np
from numpy.typing import ArrayLike

from freerock.arrays import Floats, Mask
from freerock.models.block import Block
from freerock.rotation.sensor import Laser


def displacement_from_rotation(
    theta: ArrayLike, block: Block, laser: Laser, depth_m: Floats | float = 0.0
) -> Floats:
    """Displacement of the target along the beam, positive away from the sensor, of a block that has turned.

    Origin under the base centre at rest, x to the right, y up. The half width is B, the corners turned about
    lie at ±b (b < B where they are worn). A block turned by θ about a corner has its left face on
    x = -B + y tan θ - w (1/cos θ - 1), w = B ± b, and its top on y = 2h/cos θ + (b ∓ x) tan|θ|, with the
    upper sign for θ > 0, about the right corner. The right face mirrors the left one. From there, with
    T = |θ|, for the left face at height Y and the top at X::

        left face   s = Y tan θ - w (1/cos θ - 1),   w = B + b  (θ > 0),  w = B - b  (θ < 0)
        top         -s = 2h (1/cos T - 1) + a tan T,   a = b - X  (θ > 0),  a = b + X  (θ < 0)

    The beam is on the left face while w sin θ <= Y <= w sin θ + 2h cos θ. With |X| < B the vertical beam is
    on the top while a <= (B + b) cos T - 2h sin T; where the top sinks first (b < |X|), only until it turns
    back at 2h sin T = -a. With |X| >= B the target is an outrigger at the level of the top. It begins at the
    block's edge and is as long as the beam needs: the beam is on it while 2h sin T + (B - b) cos T <= -a,
    and always when the other side goes down.

    Parameters
    ----------
    theta : array_like
        Rotation [rad], positive clockwise.
    block : Block
    laser : Laser
    depth_m : ndarray or float
        How deep the corner turned about has sunk [m], see `displaced`.

    Returns
    -------
    ndarray
        Displacement [m]; NaN where the beam is off the target of a block that has not sunk.
    """
    theta = np.asarray(theta, float)
    return np.where(on_target(theta, block, laser), displaced(theta, block, laser, depth_m), np.nan)


def displaced(theta: Floats, block: Block, laser: Laser, depth_m: Floats | float = 0.0) -> Floats:
    """`displacement_from_rotation` of a target of any size.

    A corner that has sunk by d lowers the block: a horizontal beam meets it as one at the height Y + d would
    if it had not (F32), a vertical beam reads d more. d counts from the undeformed surface for a horizontal
    beam, whose height does; from the block at rest, where it reads zero, for a vertical one.
    """
    turn = -theta if mirrored(laser) else theta
    t = np.abs(turn)
    rise = 2 * np.sin(t / 2) ** 2 / np.cos(t)  # 1/cos - 1 without loss of digits
    if laser.beam == "horizontal":
        return np.asarray((laser.position + depth_m) * np.tan(turn) - _width(turn, block) * rise)
    return np.asarray(depth_m - (block.height_m * rise + _lever(turn, block, laser) * np.tan(t)))


def rotation_from_displacement(
    displacement_m: ArrayLike, block: Block, laser: Laser, side: ArrayLike | None = None
) -> Floats:
    """Rotation of the block from the displacement of its target, inverting `displacement_from_rotation`.

    The closed forms are quadratics in the tangent of half the angle, solved without loss of digits::

        horizontal  tan(θ/2) = s / (Y + sqrt(Y² + s² - 2ws))
        top         tan(T/2) = q / (a ± sqrt(a² + q (4h + q))),  q = -s, the sign of the root that of a

    Parameters
    ----------
    displacement_m : array_like
        Displacement [m], positive away from the sensor.
    block : Block
    laser : Laser
    side : array_like, optional
        +1 or -1: sign of θ of each sample, needed only for a vertical beam that both lift (`is_unsigned`);
        `laser.release_side` throughout by default.

    Returns
    -------
    ndarray
        Rotation [rad], positive clockwise; NaN where the beam would be off the target, see there.
    """
    s = np.asarray(displacement_m, float)
    with np.errstate(divide="ignore", invalid="ignore"):
        if laser.beam == "horizontal":
            root = np.sqrt(laser.position**2 + s * (s - 2 * _width(s, block)))
            half = s / (laser.position + root)
        else:
            known = side is not None and is_unsigned(block, laser)
            sides = np.asarray(side, float) if known else _side(s, block, laser)
            lever = block.b - sides * laser.position
            root = np.copysign(np.sqrt(lever**2 + s * (s - 2 * block.height_m)), lever)
            half = np.where(s != 0, -sides * s / (lever + root), 0.0)
    theta = -2 * np.arctan(half) if mirrored(laser) else 2 * np.arctan(half)
    return np.where(on_target(theta, block, laser), theta, np.nan)


def is_unsigned(block: Block, laser: Laser) -> bool:
    """Whether both signs of θ lift the target: a vertical beam between the corners, or over a worn one."""
    x = abs(laser.position)
    return laser.beam == "vertical" and x <= block.b and x < block.width_m / 2


def sensitivity(theta: ArrayLike, block: Block, laser: Laser) -> Floats:
    """|ds/dθ|: displacement of the target per rotation [m/rad], by differentiating the closed forms."""
    turn = -np.asarray(theta, float) if mirrored(laser) else np.asarray(theta, float)
    if laser.beam == "horizontal":
        slope = laser.position - _width(turn, block) * np.sin(turn)
    else:
        slope = _lever(turn, block, laser) + block.height_m * np.sin(np.abs(turn))
    return np.asarray(np.abs(slope) / np.cos(turn) ** 2)


def beam_of(block: Block, laser: Laser) -> tuple[float, ...]:
    """A beam as `beam_kernel` takes it, compiled for floats: a length of 1 is one."""
    vertical = laser.beam == "vertical"
    return tuple(map(float, (vertical, laser.position, block.height_m, block.width_m / 2, block.b)))


def mirrored(laser: Laser) -> bool:
    """Whether the beam meets the right face, which mirrors the left one."""
    return laser.beam == "horizontal" and laser.face == "right"


def _width(turn: Floats, block: Block) -> Floats:
    """Horizontal distance w = B ± b of the face from the corner turned about."""
    return block.width_m / 2 + np.copysign(block.b, turn)


def _lever(turn: Floats, block: Block, laser: Laser) -> Floats:
    """Horizontal distance a of a vertical beam from the corner turned about, towards the block."""
    return np.where(turn > 0, block.b - laser.position, block.b + laser.position)


def _side(s: Floats, block: Block, laser: Laser) -> Floats:
    """Sign of θ of a vertical reading: by its own sign on an outrigger, else the release side."""
    if is_unsigned(block, laser):
        return np.full(s.shape, 1.0 if laser.release_side == "positive" else -1.0)
    # What is lowered turns towards the beam.
    return np.where(s > 0, 1.0, -1.0) * float(np.sign(laser.position))


def on_target(theta: Floats, block: Block, laser: Laser) -> Mask:
    """Whether the beam meets its target, see `displacement_from_rotation`."""
    turn = -theta if mirrored(laser) else theta
    t, edge = np.abs(turn), block.width_m / 2
    if laser.beam == "horizontal":
        foot = _width(turn, block) * np.sin(turn)
        return (foot <= laser.position) & (laser.position <= foot + block.height_m * np.cos(t))
    a, lift = _lever(turn, block, laser), block.height_m * np.sin(t)
    outrigger = abs(laser.position) >= edge
    rises = (a > 0) if outrigger else (a >= 0) & (a <= (edge + block.b) * np.cos(t) - lift)
    return rises | (lift + outrigger * (edge - block.b) * np.cos(t) <= -a)
