"""How many digits of the benchmark's golden solutions somebody's trajectories have.

python -m freerock_bench.golden.grade src/freerock_bench/golden/solutions/trajectories.csv
"""

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from pathlib import Path

from freerock.errors import exit_code, printable
from freerock.tables.csvfile import write_csv
from freerock_bench.document import in_markdown
from freerock_bench.golden.files import read_golden, read_solution
from freerock_bench.golden.score import HEADS, line, listing, score


def main(arguments: Sequence[str] | None = None) -> None:
    """Grade and print."""
    parser = ArgumentParser(
        "python -m freerock_bench.golden.grade",
        description="Grade somebody's solutions of the free-rocking benchmark.",
        epilog="FILE is a CSV with the columns scene, time_s, theta_rad and, if known, theta_rate_rad_s; "
        "README.md in src/freerock_bench/golden/solutions states the scenes. You may omit scenes. "
        "Prints a row for the table there, and each scene, the worst first.",
    )
    parser.add_argument("file", metavar="FILE", help="trajectories of the benchmark's scenes")
    parser.add_argument("--name", help="of the solution in the row; left out, that of the file")
    parser.add_argument("--csv", metavar="FILE", help="write the digits of every scene to a table")
    chosen = parser.parse_args(arguments)
    golden = read_golden()
    graded = score(read_solution(chosen.file), golden, chosen.file)
    print(in_markdown(HEADS, [line(graded, chosen.name or Path(chosen.file).stem, len(golden))]) + "\n")
    print(printable(listing(graded)))
    if chosen.csv:
        write_csv(graded, chosen.csv)


if __name__ == "__main__":
    sys.exit(exit_code(main))
