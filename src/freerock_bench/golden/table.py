"""The table of scores in docs/evidence.md: freerock by its tolerance, and methods without events.

python -m freerock_bench.golden.table    # renews the rows made here, half a minute
"""

import sys
from collections.abc import Iterator, Mapping

from freerock_bench.document import in_markdown, renew
from freerock_bench.golden import ours
from freerock_bench.golden.files import Trajectory, read_golden
from freerock_bench.golden.scenes import Scene, scenes
from freerock_bench.golden.score import HEADS, line, score
from freerock_bench.methods.by_name import METHODS, TIME_STEPPING, Method
from freerock_bench.methods.foundation import ode45
from freerock_bench.methods.housner import housner_eventless, housner_events
from freerock_bench.methods.problem import Problem

RTOLS = (1e-6, 1e-8, 1e-10, 1e-12, 1e-13)
# on a bed, of a rigid block, and their tolerance or step
OTHERS: dict[str, tuple[Method, Method | None, float]] = {
    "SciPy DOP853, rtol 1e-12, events of the rigid block only": (
        METHODS["SciPy DOP853, numba"],
        housner_events,
        1e-12,
    ),
    "SciPy LSODA, rtol 1e-8, no events": (METHODS["SciPy LSODA, numba"], None, 1e-8),
    "ode45 at its defaults, no events": (ode45, None, 1e-3),
    "RK4, 1 ms, no events": (TIME_STEPPING["RK4"], housner_eventless, 1e-3),
    "Newmark, 0.5 ms, no events": (TIME_STEPPING["Newmark"], None, 5e-4),
    "HHT-α, 0.5 ms, no events": (TIME_STEPPING["HHT-α"], None, 5e-4),
    "central difference, 0.5 ms, no events": (TIME_STEPPING["central difference"], None, 5e-4),
}


def rows(wanted: Mapping[str, Scene]) -> Iterator[list[str]]:
    """Rows of the table; the methods solve the free scenes of guided and of rigid blocks.

    Parameters
    ----------
    wanted : mapping of str to Scene
        What is solved, if not every scene.
    """
    golden = read_golden()
    times = {name: golden[name].time_s for name in wanted}
    for rtol in RTOLS:
        solved = {name: ours.solve(scene, rtol, float(times[name][-1])) for name, scene in wanted.items()}
        yield _row(f"freerock, rtol {rtol:g}", solved, golden)
    free = {name: scene for name, scene in wanted.items() if not scene.breaks and not scene.drop_m}
    for method, (on_bed, rigid, value) in OTHERS.items():
        by_law = {"winkler": on_bed, "hunt_crossley": on_bed, "housner": rigid}
        solved = {
            name: Trajectory(times[name], solve(_problem(scene), times[name], value).theta, None)
            for name, scene in free.items()
            if (solve := by_law[scene.law]) and (scene.law == "housner" or scene.kinematics == "guided")
        }
        yield _row(method, solved, golden)


def _row(name: str, solved: Mapping[str, Trajectory], golden: Mapping[str, Trajectory]) -> list[str]:
    return line(score(solved, golden, name), name, len(golden))


def _problem(scene: Scene) -> Problem:
    return Problem(scene.law, scene.block, scene.parameters, scene.theta0, scene.debonding)


def main(document: str = "docs/evidence.md") -> None:
    """Put the table into the document."""
    renew(document, "scores", in_markdown(HEADS, rows(scenes())))


if __name__ == "__main__":
    main(*sys.argv[1:])
