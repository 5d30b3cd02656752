"""How many digits of the golden solutions somebody's trajectories have.

    python -m freerock_bench.golden FILE         # a CSV: scene, time_s, theta_rad, if known theta_rate_rad_s

A row as in the table of the documentation, then the scenes, the worst first.
"""

import sys
from pathlib import Path

from freerock.errors import exit_code, printable
from freerock_bench.document import in_markdown
from freerock_bench.golden.files import read_golden, read_solution
from freerock_bench.golden.score import HEADS, line, listing, score


def main(*files: str) -> None:
    """Grade and print."""
    golden = read_golden()
    for name in files:
        graded = score(read_solution(name), golden, name)
        print(in_markdown(HEADS, [line(graded, Path(name).stem, len(golden))]))
        print(f"\n{printable(listing(graded))}")


if __name__ == "__main__":
    sys.exit(exit_code(lambda: main(*sys.argv[1:])))
