"""A planar block on a foundation of many cells: normal force by a law, friction sideways, nothing guided.

Position of the centre of mass x, z [m] and rotation [rad], positive clockwise, are all free. Each cell of the
base is pushed up by what lies below it and held sideways by a spring that slips at Coulomb's limit. Explicit
midpoint rule in steps of 20 µs; slip, hysteresis and creep move once a step.
"""

import math

import numpy as np
from numba import njit

GRAVITY = 9.81
STEP_S = 2e-5
EVERY = 50  # steps from sample to sample
HUNT_CROSSLEY, CREEP, DEPTH_DAMPING, HERTZ, HYSTERESIS = range(5)
HAND = 2e4, 60.0  # stiffness [N m] and damping [N m s] of the hand that turns and holds the block
GAUSS = 3**-0.5
SLOT = 5e5, 60.0  # stiffness [N/m] and damping [N s/m] across the slot in which a load moves


def flat(width_m, n=60):
    """Cells of the base: their middles [m], heights above its plane [m], slopes of it, and lengths [m]."""
    u = width_m * ((np.arange(n) + 0.5) / n - 0.5)
    return u, np.zeros(n), np.zeros(n), np.full(n, width_m / n)


def rounded(width_m, radius_m, n=60):
    """A base whose edges are arcs."""
    u, _, _, share = flat(width_m, n)
    beyond = np.maximum(np.abs(u) - (width_m / 2 - radius_m), 0.0)
    w = radius_m - np.sqrt(radius_m**2 - beyond**2)
    return u, w, np.sign(u) * beyond / np.sqrt(radius_m**2 - beyond**2), share


@njit(fastmath=False)
def _target(t, runs):
    """Angle that the hand wants [rad], and its grip from 0 to 1."""
    for i in range(runs.shape[0]):
        start, tilt, hold, fade, theta0 = runs[i]
        if t < start:
            break
        since = t - start
        if since < tilt + hold + fade:
            share = min(since / tilt, 1.0)
            grip = 1.0
            if since > tilt + hold:
                grip = 0.5 * (1 + math.cos(math.pi * (since - tilt - hold) / fade))
            return theta0 * share**3 * (10 - 15 * share + 6 * share**2), grip
    return 0.0, 0.0


@njit(fastmath=False)
def _normal(law, p, depth, rate, a, b):
    """Force per metre of base [N/m] of a point, never a pull; a and b are what it remembers."""
    if law == CREEP:
        return max(p[0] * (depth - b) + a, 0.0)
    if depth <= 0.0:
        return 0.0
    if law == HUNT_CROSSLEY:
        force = p[0] * depth + p[1] * depth * rate
    elif law == DEPTH_DAMPING:
        force = p[0] * depth + p[1] * depth * depth * rate
    elif law == HERTZ:
        force = depth**1.5 * (p[0] + p[1] * rate)
    else:
        most = max(a, depth)
        force = min(p[0] * depth, p[1] * (depth - (1 - p[0] / p[1]) * most))
    return max(force, 0.0)


@njit(fastmath=False)
def _forces(y, t, body, u, w, slope, share, law, p, memory, extra, runs):
    """Rates of the state: x, z, θ, a load's x and z; and their rates."""
    m, inertia, h, off = body
    mu, side_k, side_c, tilt, drag, load_m, load_k, load_c, load_up, floor_a, floor_w = extra
    sin, cos = math.sin(y[2]), math.cos(y[2])
    gx, gz = GRAVITY * math.sin(tilt) - floor_a * math.sin(floor_w * t), -GRAVITY * math.cos(tilt)
    fx, fz, moment = m * gx, m * gz, -drag * math.tanh(y[7] / 0.002)
    angle, grip = _target(t, runs)
    if grip > 0.0:
        moment += grip * (HAND[0] * (angle - y[2]) - HAND[1] * y[7])
    for i in range(u.size):
        # what touches of the cell, in half lengths from its middle
        depth, deeper = (
            -(y[1] + (w[i] - h) * cos - (u[i] - off) * sin),
            0.5 * share[i] * (sin - cos * slope[i]),
        )
        slid = y[0] + (u[i] - off) * cos + (w[i] - h) * sin - memory[2, i]
        low, high = -1.0, 1.0
        if law != CREEP:
            if depth <= -abs(deeper):
                continue
            if depth < abs(deeper) and deeper > 0.0:
                low = -depth / deeper
            elif depth < abs(deeper):
                high = -depth / deeper
        for gauss in (-GAUSS, GAUSS):
            at = 0.5 * (low + high) + 0.5 * (high - low) * gauss
            along = u[i] - off + 0.5 * share[i] * at
            up = w[i] - h + 0.5 * share[i] * slope[i] * at
            rx, rz = along * cos + up * sin, up * cos - along * sin
            part = 0.25 * share[i] * (high - low)
            # of the point: ẋ + θ̇ rz, ż - θ̇ rx
            force = part * _normal(
                law, p, depth + deeper * at, -(y[6] - y[7] * rx), memory[0, i], memory[1, i]
            )
            if force <= 0.0:
                continue
            aside = -part * (side_k * slid + side_c * (y[5] + y[7] * rz))
            aside = min(max(aside, -mu * force), mu * force)
            fx += aside
            fz += force
            moment += aside * rz - force * rx
    rates = np.zeros(10)
    rates[:5] = y[5:]
    if load_m > 0.0:
        rx, rz = (
            load_up * sin,
            load_up * cos,
        )  # of its place in the block, which it leaves by (away, off_slot)
        dx, dz = y[3] - y[0] - rx, y[4] - y[1] - rz
        vx, vz = y[8] - y[5] - y[7] * rz, y[9] - y[6] + y[7] * rx
        away, off_slot = dx * cos - dz * sin, dx * sin + dz * cos
        along = -load_k * away - load_c * ((vx * cos - vz * sin) - y[7] * off_slot)
        across = -SLOT[0] * off_slot - SLOT[1] * ((vx * sin + vz * cos) + y[7] * away)
        px, pz = along * cos + across * sin, across * cos - along * sin
        rates[8], rates[9] = px / load_m + gx, pz / load_m + gz
        fx -= px
        fz -= pz
        # the forces act where the load is, so that nothing turns of itself
        moment -= (rz + dz) * px - (rx + dx) * pz
    rates[5], rates[6], rates[7] = fx / m, fz / m, moment / inertia
    return rates


@njit(fastmath=False)
def _stored(law, p, depth, a, b):
    """Energy per metre of base [J/m] that a point would give back; a and b are what it remembers."""
    if law == CREEP:
        spring, relaxing = p[0] * (depth - b) ** 2 / 2, a * a / (2 * p[1])
        return spring + relaxing if _normal(law, p, depth, 0.0, a, b) > 0.0 else 0.0
    if depth <= 0.0:
        return 0.0
    if law == HERTZ:
        return p[0] * depth**2.5 / 2.5
    if law == HYSTERESIS:  # it is let off along the steeper line
        return _normal(law, p, depth, 0.0, a, b) ** 2 / (2 * p[1])
    return p[0] * depth * depth / 2


@njit(fastmath=False)
def _energy(y, body, u, w, slope, share, law, p, memory, extra):
    """Mechanical energy [J]: kinetic, of weight, of the bed and of what holds the base sideways."""
    m, inertia, h, off = body
    _, side_k, _, tilt, _, load_m, load_k, _, load_up, _, _ = extra
    sin, cos, up = math.sin(y[2]), math.cos(y[2]), np.array([-math.sin(tilt), math.cos(tilt)])
    found = 0.5 * m * (y[5] ** 2 + y[6] ** 2) + 0.5 * inertia * y[7] ** 2
    found += m * GRAVITY * (y[0] * up[0] + y[1] * up[1])
    for i in range(u.size):
        depth = -(y[1] + (w[i] - h) * cos - (u[i] - off) * sin)
        deeper = 0.5 * share[i] * (sin - cos * slope[i])
        for gauss in (-GAUSS, GAUSS):
            at = depth + deeper * gauss
            found += 0.5 * share[i] * _stored(law, p, at, memory[0, i], memory[1, i])
        if _normal(law, p, depth, 0.0, memory[0, i], memory[1, i]) > 0.0:
            slid = y[0] + (u[i] - off) * cos + (w[i] - h) * sin - memory[2, i]
            found += 0.5 * share[i] * side_k * slid**2
    if load_m > 0.0:
        dx, dz = y[3] - y[0] - load_up * sin, y[4] - y[1] - load_up * cos
        found += 0.5 * load_m * (y[8] ** 2 + y[9] ** 2) + load_m * GRAVITY * (y[3] * up[0] + y[4] * up[1])
        found += 0.5 * load_k * (dx * cos - dz * sin) ** 2 + 0.5 * SLOT[0] * (dx * sin + dz * cos) ** 2
    return found


@njit(fastmath=False)
def _remember(y, body, u, w, law, p, memory, mu, side_k, dt):
    """Slip, creep and hysteresis of all points over a step."""
    h, off = body[2], body[3]
    sin, cos = math.sin(y[2]), math.cos(y[2])
    for i in range(u.size):
        along, up = u[i] - off, w[i] - h
        rx, rz = along * cos + up * sin, up * cos - along * sin
        depth, rate, place = -(y[1] + rz), -(y[6] - y[7] * rx), y[0] + rx
        force = _normal(law, p, depth, rate, memory[0, i], memory[1, i])
        if law == CREEP:
            soft, relaxing, seconds, yields, flow = p
            if force > 0.0:
                memory[0, i] += dt * (relaxing * rate - memory[0, i] / seconds)
                if force > yields:
                    memory[1, i] += dt * (force - yields) / flow
            else:
                memory[0, i] -= dt * memory[0, i] / (seconds * (1 + relaxing / soft))
        elif law == HYSTERESIS:
            memory[0, i] = max(memory[0, i], depth) if depth > 0.0 else 0.0
        if force <= 0.0:
            memory[2, i] = place
        elif side_k * abs(place - memory[2, i]) > mu * force:
            memory[2, i] = place - math.copysign(mu * force / side_k, place - memory[2, i])


@njit(fastmath=False)
def _march(y, samples, every, dt, body, u, w, slope, share, law, p, memory, extra, runs):
    found, energy = np.empty((samples, 10)), np.empty(samples)
    found[0], energy[0] = y, _energy(y, body, u, w, slope, share, law, p, memory, extra)
    for i in range(1, samples * every):
        t = (i - 1) * dt
        middle = y + 0.5 * dt * _forces(y, t, body, u, w, slope, share, law, p, memory, extra, runs)
        y = y + dt * _forces(middle, t + 0.5 * dt, body, u, w, slope, share, law, p, memory, extra, runs)
        _remember(y, body, u, w, law, p, memory, extra[0], extra[1], dt)
        if i % every == 0:
            found[i // every] = y
            energy[i // every] = _energy(y, body, u, w, slope, share, law, p, memory, extra)
    return found, energy


def rock(block, base, law, values, runs, until_s, *, finer=1, **extra):
    """Motion of a block that is turned, held and let go.

    Parameters
    ----------
    block : mapping
        height_m, width_m, mass_kg and, if off the middle, centre_off_m (to the right).
    base : (u, w, slope, share)
        Of `flat` or `rounded`, or shaped otherwise.
    law, values
        One of the laws above and its constants, per metre of base.
    runs : sequence of (start_s, tilt_s, hold_s, fade_s, theta0_rad)
    until_s : float
    finer : int
        How many times as many steps.
    extra
        mu; side_k [N/m²] and side_c, what holds a cell sideways; tilt [rad] of the ground, down to the
        right; drag [N m], friction against turning; load_m [kg], load_k [N/m], load_c [N s/m], load_up [m], a
        load on a spring along the block's width, so high above the centre of mass;
        floor_a [m/s²], floor_w [rad/s], the floor's vibration.

    Returns
    -------
    ndarray, shape (n_time, 4)
        x, z of the centre of mass [m], θ [rad] and the energy [J], every millisecond.
    """
    m, b, h = block["mass_kg"], block["width_m"] / 2, block["height_m"] / 2
    off = block.get("centre_off_m", 0.0)
    body = np.array([m, m * (b * b + h * h) / 3, h, off])
    usual = {"mu": 0.6, "side_k": 5e6, "side_c": 2e3, "tilt": 0.0, "drag": 0.0}
    usual |= {"load_m": 0.0, "load_k": 0.0, "load_c": 0.0, "load_up": 0.0, "floor_a": 0.0, "floor_w": 0.0}
    assert set(extra) <= set(usual), extra
    extra = usual | extra
    y = np.zeros(10)
    y[:5] = off, h, 0.0, off, h + extra["load_up"]
    memory = np.zeros((3, base[0].size))
    memory[2] = base[0]
    found, energy = _march(
        y,
        round(1000 * until_s),
        EVERY * finer,
        STEP_S / finer,
        body,
        *base,
        law,
        np.array(values, float),
        memory,
        np.array([extra[name] for name in usual], float),
        np.array(runs, float),
    )
    return np.column_stack([found[:, :3], energy])
