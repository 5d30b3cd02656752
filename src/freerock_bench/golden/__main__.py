"""How many digits of the golden solutions freerock has, or somebody else's trajectories.

    python -m freerock_bench.golden              # freerock at five tolerances, half a minute
    python -m freerock_bench.golden FILE         # a CSV: scene, time_s, theta_rad, if known theta_rate_rad_s

A row for the table in the documentation; of a file each scene besides, the worst first.
"""

import sys
from collections.abc import Mapping
from pathlib import Path

from freerock.errors import exit_code, printable
from freerock.tables.csvfile import write_csv
from freerock_bench.document import in_markdown
from freerock_bench.golden import ours
from freerock_bench.golden.files import Trajectory, read_golden, read_solution
from freerock_bench.golden.scenes import scenes
from freerock_bench.golden.score import HEADS, line, listing, score

RTOLS = (1e-6, 1e-8, 1e-10, 1e-12, 1e-13)


def solved(rtol: float, golden: Mapping[str, Trajectory]) -> dict[str, Trajectory]:
    """freerock's trajectory of each scene."""
    return {name: ours.solve(each, rtol, float(golden[name].time_s[-1])) for name, each in scenes().items()}


def main(*files: str) -> None:
    """Grade and print."""
    golden = read_golden()
    given = {Path(name).stem: read_solution(name) for name in files}
    given = given or {f"freerock, rtol {rtol:g}": solved(rtol, golden) for rtol in RTOLS}
    graded = {name: score(each, golden, name) for name, each in given.items()}
    print(in_markdown(HEADS, [line(each, name, len(golden)) for name, each in graded.items()]))
    for name, each in graded.items():
        if files:
            print(f"\n{printable(listing(each))}")
        else:
            write_csv(each, Path("results/studies/golden", f"{name}.csv"))


if __name__ == "__main__":
    sys.exit(exit_code(lambda: main(*sys.argv[1:])))
