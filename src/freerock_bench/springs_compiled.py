"""What `springs` has compiled: forces of the bed, rates of all states, steps, impacts.

Arguments are as `springs.Scene.numbers` and `springs.Scene.cells` give them.
"""

import math

import numpy as np

from freerock.models.block import GRAVITY
from freerock.models.compiled import compiled

GAUSS = 3**-0.5
DULL_RAD_S, DULL_M_S = 2e-3, 1e-3  # rates over which dry friction and hysteresis turn round
AT_REST = 2e-5  # [rad]
STEP_S, STILL_S = 5e-5, 1.0  # at the end of a motion the block has been at rest for so long
N = 12  # coordinates and rates, without what friction and bed remember
BRISTLE_N_M, BRISTLE_NS_M = 2e7, 2e3  # what friction holds by before it slips


@compiled()
def stored(y, cells, e, h):  # type: ignore[no-untyped-def]
    """Energy of a bed over its stiffness [m³]."""
    sin, cos = math.sin(y[2]), math.cos(y[2])
    low = y[1] + e * sin - h * cos
    total = 0.0
    for i in range(cells.shape[0]):
        u, half, height, slope, stiff = cells[i]
        depth, deeper = y[5] - low + u * sin - height * cos, half * (sin - slope * cos)
        most, least = depth + abs(deeper), depth - abs(deeper)
        if most <= 0.0:
            continue
        share = 1.0 if least > 0.0 else most / (most - least)
        least = max(least, 0.0)
        total += stiff * half * share * (most * most + most * least + least * least) / 3.0
    return total


@compiled()
def bed_force(y, law, cells, besides, pulls):  # type: ignore[no-untyped-def]
    """Upward force [N], its moment about the base's middle by u, and rates of what the bed remembers."""
    lags, relaxing, relaxes, loose = besides[3], besides[4], besides[5], besides[6]
    k, c, lam = law
    sin, cos = math.sin(y[2]), math.cos(y[2])
    force = moment = 0.0
    e, h = pulls
    low = y[1] + e * sin - h * cos
    low_rate = y[7] + (e * cos + h * sin) * y[8]
    n = cells.shape[0]
    forgets = np.zeros(n if relaxing > 0.0 else 0)
    for i in range(n):
        u, half, height, slope, stiffer = cells[i]
        depth, deeper = y[5] - low + u * sin - height * cos, half * (sin - slope * cos)
        bent = 0.0
        if relaxing > 0.0:
            rate = y[11] - low_rate + (u * cos + height * sin) * y[8]
            bent = y[N + 1 + i]
            forgets[i] = -bent / relaxes + (relaxing * k * rate if depth > 0.0 else 0.0)
        if depth <= -abs(deeper):
            continue
        first, last = -1.0, 1.0
        if depth < abs(deeper):
            if deeper > 0.0:
                first = -depth / deeper
            else:
                last = -depth / deeper
        for node in (-GAUSS, GAUSS):
            at = 0.5 * (first + last) + 0.5 * (last - first) * node
            place, z = u + half * at, depth + deeper * at
            rate = y[11] - low_rate + (place * cos + height * sin) * y[8]
            stiff = k * stiffer * (1.0 + lags * math.tanh(rate / DULL_M_S))
            f = stiff * z + (c + lam * z) * rate + bent
            if loose > 0.0:
                f = max(f, 0.0)
            part = 0.5 * half * (last - first) * f
            force, moment = force + part, moment + part * place
    return force, moment, forgets


@compiled()
def rates_of(t, y, body, law, cells, besides, hand, fade):  # type: ignore[no-untyped-def]
    """Of all states; the hand is a couple that fades."""
    m, inertia, e, h, top, up, left, right, pivots = body
    top_hz, table, x_hz, y_hz, lost, grip, air, rub, tilt = besides[8:]
    theta, q, w, vq = y[2], y[3], y[8], y[9]
    sin, cos = math.sin(theta), math.cos(theta)
    force, moment, forgets = bed_force(y, law, cells, besides, (e, h))
    gx, gy = GRAVITY * math.sin(tilt), -GRAVITY * math.cos(tilt)
    mass, right_side = np.zeros((7, 7)), np.zeros(7)
    mass[0, 0] = mass[1, 1] = m
    mass[2, 2] = inertia
    mass[3, 3] = mass[4, 4] = mass[5, 5] = 1.0
    mass[6, 6] = 1.0
    right_side[0], right_side[1] = m * gx, m * gy + force
    # of a point at (u, v) of the base's frame: by θ it moves (b, -a), with (a, b) from the centre turned
    place = moment / force if force > 0.0 else 0.0
    right_side[2] = -((place - e) * cos - h * sin) * force
    right_side[2] -= air * w * abs(w) + rub * math.tanh(w / DULL_RAD_S)
    if t < fade:
        right_side[2] += hand * 0.5 * (1 + math.cos(math.pi * t / fade))
    if top > 0.0:  # at (q, up) of the base's frame: rows of J are its moves by x, y, θ, q
        a, b = (q - e) * cos + (up - h) * sin, -(q - e) * sin + (up - h) * cos
        jx, jy = (1.0, 0.0, b, cos), (0.0, 1.0, -a, -sin)
        bx, by = -a * w * w - 2 * sin * w * vq, -b * w * w - 2 * cos * w * vq
        mass[3, 3] = 0.0
        for i in range(4):
            right_side[i] += top * (jx[i] * (gx - bx) + jy[i] * (gy - by))
            for j in range(4):
                mass[i, j] += top * (jx[i] * jx[j] + jy[i] * jy[j])
        turn = 2 * math.pi * top_hz
        right_side[3] -= top * (turn * turn * q + 2 * lost * turn * vq)
    if table > 0.0:
        mass[4, 4] = mass[5, 5] = table
        along, across = 2 * math.pi * x_hz, 2 * math.pi * y_hz
        if x_hz > 0.0:
            right_side[4] = -table * (along * along * y[4] + 2 * lost * along * y[10])
        if y_hz > 0.0:
            right_side[5] = -force - table * (across * across * y[5] + 2 * lost * across * y[11])
    corner = (right if theta > 0.0 else left) if pivots > 0.0 else 0.0
    slides = 0.0
    if grip > 0.0:
        b = -(place - e) * sin - h * cos
        v = y[6] + b * w - y[10]
        most = grip * max(force, 0.0)
        hold = BRISTLE_N_M * y[N] + BRISTLE_NS_M * v
        hold = min(max(-hold, -most), most)
        slides = v if (most > 0.0 and abs(BRISTLE_N_M * y[N]) < most) or v * y[N] < 0.0 else 0.0
        right_side[0] += hold
        right_side[2] += hold * b
        if x_hz > 0.0:
            right_side[4] -= hold
    else:
        a, b = (corner - e) * cos - h * sin, -(corner - e) * sin - h * cos
        mass[0, 6], mass[2, 6] = -1.0, -b
        mass[6, 0], mass[6, 2], mass[6, 6] = 1.0, b, 0.0
        right_side[6] = a * w * w
        if table > 0.0 and x_hz > 0.0:
            mass[6, 4], mass[4, 6] = -1.0, 1.0
    speeds = np.linalg.solve(mass, right_side)
    found = np.zeros(y.shape[0])
    found[:6], found[6:N] = y[6:N], speeds[:6]
    found[N] = slides
    if besides[4] > 0.0:
        found[N + 1 :] = forgets
    return found


@compiled()
def march(given, y, how, impacts, states, passages):  # type: ignore[no-untyped-def]
    """Fills states and instants of impacts; how many of each. A step ends where the block stands upright."""
    sample_s, rests, lifts, hit_s, kept, added = how
    steps = math.ceil(sample_s / STEP_S)
    still, top, count = 0, abs(y[2]), 0
    body, fresh, law = given[0], given[1], given[1].copy()
    for i in range(states.shape[0]):
        states[i] = y[:N]
        still = still + 1 if abs(y[2] - rests) < AT_REST else 0
        if still * sample_s > STILL_S:
            return i + 1, count
        for j in range(steps):
            t, left = i * sample_s + j * sample_s / steps, sample_s / steps
            if t + 0.5 * left > hit_s:
                y[6:N] *= kept
                turn(body, y, added)
                hit_s = math.inf
            after = step_of(given, law, t, left, y)
            if after[2] * y[2] < 0.0:
                t, left, y = upright(given, law, t, left, y)
                if top > lifts:
                    if count < impacts.shape[0]:
                        turn(body, y, (impacts[count, 0] - 1.0) * y[8])
                        law[0] = fresh[0] * impacts[count, 1]
                        law[1], law[2] = fresh[1] * impacts[count, 2], fresh[2] * impacts[count, 2]
                    passages[min(count, passages.size - 1)] = t
                    count += 1
                top = 0.0
                after = step_of(given, law, t, left, y)
            y = after
            top = max(top, abs(y[2]))
    return states.shape[0], count


@compiled()
def upright(given, law, t, dt, y):  # type: ignore[no-untyped-def]
    """Instant at which the block stands upright within a step, what is left of it, and the state then."""
    low, high = 0.0, dt
    for _ in range(40):
        middle = 0.5 * (low + high)
        if step_of(given, law, t, middle, y)[2] * y[2] > 0.0:
            low = middle
        else:
            high = middle
    return t + high, dt - high, step_of(given, law, t, high, y)


@compiled()
def step_of(given, law, t, dt, y):  # type: ignore[no-untyped-def]
    """State after a step of Runge and Kutta."""
    body, _, cells, besides, hand, fade = given
    one = rates_of(t, y, body, law, cells, besides, hand, fade)
    two = rates_of(t + 0.5 * dt, y + 0.5 * dt * one, body, law, cells, besides, hand, fade)
    three = rates_of(t + 0.5 * dt, y + 0.5 * dt * two, body, law, cells, besides, hand, fade)
    four = rates_of(t + dt, y + dt * three, body, law, cells, besides, hand, fade)
    return y + dt / 6.0 * (one + 2.0 * two + 2.0 * three + four)


@compiled()
def turn(body, y, by):  # type: ignore[no-untyped-def]
    """Give it a rate of rotation about its lower corner, upright about its middle [rad/s], in place."""
    e, h, left, right, pivots = body[2], body[3], body[6], body[7], body[8]
    sin, cos = math.sin(y[2]), math.cos(y[2])
    corner = 0.0 if abs(y[2]) < 1e-9 else (right if y[2] > 0.0 else left)
    held = corner if pivots > 0.0 else 0.0
    y[6] += ((held - e) * sin + h * cos) * by
    y[7] += ((corner - e) * cos - h * sin) * by
    y[8] += by
