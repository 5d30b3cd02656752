"""freerock's own solutions of the scenes."""

import math

import numpy as np

from freerock.arrays import Floats
from freerock.models.block_on_bed import State
from freerock.models.ground import GroundMotion, pulse
from freerock.models.laws import Rules
from freerock.models.simulate import Response, Solver, simulate
from freerock_bench.golden.files import Trajectory
from freerock_bench.golden.scenes import PULSE_PERIOD_S, PULSE_START_S, Scene, instants


def solve(scene: Scene, rtol: float = 1e-12, until_s: float | None = None) -> Trajectory:
    """θ(t) of a scene up to an instant [s], that of the benchmark if None; the rest as in `response`."""
    time = np.array(instants() if until_s is None else instants(until_s))
    found = response(scene, time, rtol)
    return Trajectory(time, found.theta, found.theta_rate)


def response(scene: Scene, time: Floats, rtol: float) -> Response:
    """Motion of a scene by `freerock.models.simulate`.

    Parameters
    ----------
    scene : Scene
    time : ndarray, shape (n_time,)
        Instants since the release [s].
    rtol : float
        Of the integrator; free motion of Housner's block has none.
    """
    return simulate(
        scene.law,
        scene.block,
        scene.parameters,
        time,
        theta0=start(scene),
        base_excitation=ground(scene),
        rules=Rules(scene.debonding, scene.kinematics),
        solver=Solver(rtol),
    )


def start(scene: Scene) -> float | State:
    """The angle of release, or the state of a block that is dropped."""
    if not scene.drop_m:
        return scene.theta0
    return State(-scene.block.b * math.sin(abs(scene.theta0)) - scene.drop_m, 0.0, scene.theta0, 0.0)


def ground(scene: Scene) -> GroundMotion | None:
    """The motion of the ground, None where it is still."""
    x, z = scene.pulse
    return pulse("sine", PULSE_PERIOD_S, x=x, z=z, start_s=PULSE_START_S) if scene.breaks else None
