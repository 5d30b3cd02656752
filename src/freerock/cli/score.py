"""How many digits of the benchmark's golden solutions somebody's trajectories have."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from freerock.errors import printable


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    parser.epilog = (
        "example:\n"
        "  freerock score src/freerock/studies/golden/solutions/trajectories.csv\n"
        "\n"
        "FILE is a CSV with the columns scene, time_s, theta_rad and, if known, theta_rate_rad_s, or a\n"
        "netCDF file like golden.nc; docs/benchmark.md states the scenes. Any of them may be left out.\n"
        "Prints a row for the table there, and each scene, the worst first."
    )
    parser.add_argument("file", metavar="FILE", help="trajectories of the benchmark's scenes")
    parser.add_argument("--name", help="of the solution in the row; left out, that of the file")
    parser.add_argument("--csv", metavar="FILE", help="write the digits of every scene to a table")


def run(chosen: Namespace) -> None:
    """Grade and print."""
    from freerock.studies.golden.files import read_golden, read_solution
    from freerock.studies.golden.score import HEAD, line, listing, score
    from freerock.tables.csvfile import write_csv

    golden = read_golden()
    graded = score(read_solution(chosen.file), golden, chosen.file)
    print(f"{HEAD}\n{line(graded, chosen.name or Path(chosen.file).stem, len(golden))}\n")
    print(printable(listing(graded)))
    if chosen.csv:
        write_csv(graded, chosen.csv)
