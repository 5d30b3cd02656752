"""A rigid block that rolls over the arcs of its edges, or over sharp ones, with any law of impact.

SciPy's DOP853 from impact to impact. θ is positive clockwise. The block does not slip.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

GRAVITY = 9.81
LEAST_RAD = 2e-5  # the block lies still below


def _rates(block, theta, rate, radius, hand=0.0):
    """Angular acceleration of a block on the edge that it leans over; hand in N m."""
    m, b, h = block["mass_kg"], block["width_m"] / 2, block["height_m"] / 2
    side, t = (1 if theta >= 0 else -1), abs(theta)
    sin, cos, across, up = math.sin(t), math.cos(t), b - radius, h - radius
    x1, z1 = radius + across * sin + up * cos, across * cos - up * sin
    x2, z2 = z1, -across * sin - up * cos
    inertia = m * (b * b + h * h) / 3 + m * (x1 * x1 + z1 * z1)
    return side * (-m * GRAVITY * z1 - m * (x1 * x2 + z1 * z2) * rate**2 + side * hand) / inertia


def rock(block, restitution, runs, until_s, radius=0.0):
    """θ [rad] every millisecond, and all impacts as (time [s], θ̇ before, θ̇ after).

    Parameters
    ----------
    restitution : callable
        Of the rate before the impact [rad/s] → the share that is left.
    runs : sequence of (start_s, tilt_s, hold_s, fade_s, theta0_rad)
    """
    time = np.arange(round(1000 * until_s)) / 1000
    theta, impacts = np.zeros(time.size), []
    for start, tilt, hold, fade, theta0 in runs:
        share = np.clip((time - start) / tilt, 0, 1)
        held = (time >= start) & (time < start + tilt + hold)
        theta[held] = (theta0 * share**3 * (10 - 15 * share + 6 * share**2))[held]
        t, y = start + tilt + hold, [theta0, 0.0]
        bears = -_rates(block, theta0, 0.0, radius) * _inertia(block, theta0, radius)

        def rates(now, y, let_go=t, fade=fade, bears=bears):
            grip = 0.5 * (1 + math.cos(math.pi * min((now - let_go) / fade, 1.0)))
            return [y[1], _rates(block, y[0], y[1], radius, grip * bears)]

        side, free = math.copysign(1, theta0), start + tilt + hold + fade
        while t < time[-1]:

            def flat(now, y):
                return y[0]

            flat.terminal, flat.direction = True, -side
            step = solve_ivp(
                rates,
                (t, free if t < free else time[-1] + 1e-3),
                [y[0] or side * 1e-15, y[1]],  # on the new edge
                "DOP853",
                events=flat,
                dense_output=True,
                rtol=1e-11,
                atol=1e-13,
            )
            inside = (time >= t) & (time < step.t[-1])
            theta[inside] = step.sol(time[inside])[0]
            t, y = step.t[-1], list(step.y[:, -1])
            if not step.t_events[0].size:
                continue
            after = y[1] * restitution(y[1])
            impacts.append((t, y[1], after))
            side, y = -side, [0.0, after]
            if _height(block, after, radius) < LEAST_RAD:
                break
    return theta, impacts


def _inertia(block, theta, radius):
    m, b, h = block["mass_kg"], block["width_m"] / 2, block["height_m"] / 2
    t = abs(theta)
    x1 = radius + (b - radius) * math.sin(t) + (h - radius) * math.cos(t)
    z1 = (b - radius) * math.cos(t) - (h - radius) * math.sin(t)
    return m * (b * b + h * h) / 3 + m * (x1 * x1 + z1 * z1)


def _height(block, rate, radius):
    """How far it will turn, nearly [rad]."""
    b = block["width_m"] / 2
    return _inertia(block, 0.0, radius) * rate**2 / (2 * block["mass_kg"] * GRAVITY * (b - radius))


def left_corner(block, theta, radius=0.0):
    """Where the left end of the base's plane is: x, z [m]."""
    b = block["width_m"] / 2
    side = np.where(theta >= 0, 1, -1)
    x, z = side * (b - radius) + radius * theta, radius
    u, w = -b - side * (b - radius), -radius
    return x + u * np.cos(theta) + w * np.sin(theta), z - u * np.sin(theta) + w * np.cos(theta)
