"""What the drivers of the engines share: a hand that turns a box in space, holds it and lets it go.

A driver reads one scene as JSON from standard input and answers with rows of (x of the left face at the
laser's height [m], θ [rad]), one a millisecond.
"""

import json
import math
import sys

import numpy as np

HAND = 2e3, 8.0  # stiffness [N m] and damping [N m s]


def scene():
    """The scene on standard input."""
    return json.load(sys.stdin)


def wanted(t, runs):
    """Angle that the hand wants [rad], and its grip from 0 to 1."""
    for start, tilt, hold, fade, theta0 in runs:
        since = t - start
        if 0 <= since < tilt + hold + fade:
            share = min(since / tilt, 1.0)
            grip = 1.0
            if since > tilt + hold:
                grip = 0.5 * (1 + math.cos(math.pi * (since - tilt - hold) / fade))
            return theta0 * share**3 * (10 - 15 * share + 6 * share**2), grip
    return 0.0, 0.0


def couple(rotation, spin, angle, grip, crooked):
    """Moment of the hand [N m] on a body with a rotation matrix and a spin [rad/s].

    The hand turns it by an angle about the axis y, which lies askew by `crooked` in the plane of the ground.
    """
    axis = np.array([math.sin(crooked), math.cos(crooked), 0.0])
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    aim = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    off = aim @ rotation.T
    way = 0.5 * np.array([off[2, 1] - off[1, 2], off[0, 2] - off[2, 0], off[1, 0] - off[0, 1]])
    return grip * (HAND[0] * way - HAND[1] * np.asarray(spin))


def seen(place, rotation, half_width, height):
    """x of the left face where the laser meets it [m], from centre and rotation; and θ about y."""
    normal = rotation[:, 0]
    on_face = place - half_width * normal
    beam = np.array([on_face[0], 0.0, height])
    x = beam[0] + normal @ (on_face - beam) / normal[0]
    return float(x), math.atan2(rotation[0, 2], rotation[2, 2])


def answer(rows):
    """Say what was found."""
    json.dump(rows, sys.stdout)
