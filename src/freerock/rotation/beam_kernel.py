"""The geometry of `beam` number by number, compiled: fits use it thousands of times.

Angles and displacements are those of the left face and of the top; who asks mirrors the right face. A beam
is (1 where it is vertical or 0, position, height, half width B, half distance b of the corners turned about),
all in metres. With t = tan(θ/2): tan θ = 2t/(1 - t²), sin θ = 2t/(1 + t²), 1/cos θ - 1 = t tan θ.
"""

import math

from freerock.models.compiled import compiled
from freerock.models.kernel import depth_at_rest

CLOSE = 1e-14  # share of a reading to which the angle of a held block is found
MOST = 12  # secants to that
SMALL = 0.02  # up to it the series of an arctangent is exact to 6e-17
STILL = 1e-12  # rad: a horizontal beam shows it as it is
BEYOND = 1.5  # rad: the block has fallen


@compiled(forceinline=True)
def beam_displacement(half, sunk, sinks, beam):
    """`beam.displaced` of a rotation whose half has this tangent: (F30) to (F32); sunk is the depth of the
    base centre where it sinks, else 0."""
    vertical, place, height, edge, corner = beam
    square = half * half
    slope = 2 * half / (1 - square)
    if sinks:
        sunk += corner * abs(2 * half / (1 + square))
    if vertical:
        lever = corner - place if half > 0 else corner + place
        return sunk - abs(slope) * (height * abs(half) + lever)
    width = edge + corner if half > 0 else edge - corner
    return slope * (place + sunk - width * half)


@compiled(forceinline=True)
def half_tangent(s, near, beam):
    """Tangent of half of `beam.rotation_from_displacement` of a target of any size, on the side of a rotation
    near to it."""
    vertical, place, height, edge, corner = beam
    if vertical:
        side = 1.0 if near > 0 else -1.0
        lever = corner - side * place
        root = math.copysign(math.sqrt(lever * lever + s * (s - 2 * height)), lever)
        return -side * s / (lever + root) if s != 0 else 0.0
    width = edge + corner if s > 0 else edge - corner
    return s / (place + math.sqrt(place * place + s * (s - 2 * width)))


@compiled(forceinline=True)
def arctangent(x):
    """atan x; of what is small by its series."""
    if abs(x) < SMALL:
        square = x * x
        return x * (1 - square * (1 / 3 - square * (1 / 5 - square / 7)))
    return math.atan(x)


@compiled()
def seen(theta, z_cb, weights, rests, sign, beam, expected, out):
    """`view.View.seen`; rests is the depth from which the beam counts, NaN where no corner sinks; the reading
    of a beam is taken for that of the one expected."""
    sinks = rests == rests
    for i in range(out.size):
        mean = reading = 0.0
        for j in range(weights.size):
            mean += weights[j] * sign * theta[j, i]
        if not beam[0] and not abs(mean) > STILL:
            out[i] = sign * mean
            continue
        turn = half = 0.0
        for j in range(weights.size):
            turn = sign * theta[j, i]
            half = math.tan(0.5 * turn)
            sunk = z_cb[j, i] - rests if sinks else 0.0
            reading += weights[j] * beam_displacement(half, sunk, sinks, beam)
        found = half_tangent(reading, mean, expected)
        # beside the last moment's rotation, by the tangent of a difference
        found = turn + 2 * arctangent((found - half) / (1 + found * half))
        out[i] = sign * (found if abs(mean) < BEYOND and found == found else mean)


@compiled()
def released(turn, law, rests, beam, expected):
    """`view.View.released`; law as `models.kernel` has it, its k 0 where no corner sinks."""
    reading = beam_displacement(math.tan(0.5 * turn), 0.0, False, expected)
    before, error_before, now = turn, math.nan, turn
    for i in range(MOST):
        sinks = law[0] > 0
        sunk = depth_at_rest(abs(math.sin(now)), law)[0] - rests if sinks else 0.0
        error = beam_displacement(math.tan(0.5 * now), sunk, sinks, beam) - reading
        if abs(error) <= CLOSE * abs(reading) or error == error_before:
            break
        slope = (error - error_before) / (now - before) if i > 0 else reading / turn
        before, error_before, now = now, error, now - error / slope
    return now
