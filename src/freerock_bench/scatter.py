"""Impacts that scatter: law, numbers, σ_r, restitution, means and the next run, from volts, against truth.

    python -m freerock_bench.scatter --per-cell 30 --sigma 0 0.003 0.01 0.03 --seed 1

makes records of `scattered`, three runs each, analyses them by the workflow, prints a column for each σ_r and
the numbers farthest from their truth; results/studies/scatter.csv has a row for each, and two charts.
"""

import argparse
from pathlib import Path

from freerock.figures.style import save
from freerock_bench import campaigns
from freerock_bench.figures import coverage, parsimony
from freerock_bench.scattered import make


def main(arguments: list[str] | None = None) -> None:
    """Make, analyse, grade, print."""
    parser = argparse.ArgumentParser(prog="python -m freerock_bench.scatter")
    parser.add_argument("--per-cell", type=int, default=30, help="records of each σ_r; thirty make a round")
    parser.add_argument("--first", type=int, default=0, help="number of the first record")
    parser.add_argument("--sigma", type=float, nargs="+", default=[0.0, 0.003, 0.01, 0.03])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cores", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=Path("results/studies/scatter"))
    parser.add_argument("--document", default="")
    given = parser.parse_args(arguments)
    numbers = range(given.first, given.first + given.per_cell)
    cases = [(sigma, i) for sigma in given.sigma for i in numbers]
    records = campaigns.made(lambda case: make(given.folder / "records", case[0], case[1], given.seed), cases)
    tables = campaigns.analysed(given.folder.resolve(), records, given.cores)
    frame = campaigns.graded(tables, records, lambda truth: f"σ_r {100 * float(truth['true_sigma_r']):g} %")
    campaigns.finish(frame, "scatter", given.document)
    print(campaigns.worst(frame))
    for figure, drawn in ("coverage", coverage.draw(frame)), ("parsimony", parsimony.draw(tables["choice"])):
        save(*drawn, Path("results/studies/figures", figure))


if __name__ == "__main__":
    main()
