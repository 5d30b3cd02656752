"""Studies of this version, and the numbers that the documentation takes from them.

    python -m freerock_bench.evidence                # studies whose table is older than the code it judges
    python -m freerock_bench.evidence scatter kinds  # these, be they older or not
    python -m freerock_bench.evidence --size small   # a few cases of each; nothing of docs/ is renewed
    python -m freerock_bench.evidence none           # the documentation alone, from the tables as they are

A study writes docs/evidence/NAME.csv, whose first line states version, seed, and checksums of the code that
it judges and of its rows. From these files alone come the tables of docs/evidence.md and the numbers of
docs/evidence/numbers.csv, which texts cite as `<!--name-->number<!--/-->` and which
docs/evidence.md lists: where each stands, of which rows it is made.
"""

import argparse
import csv
import hashlib
import io
import re
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from freerock.errors import FreerockError, exit_code
from freerock.figures.style import save
from freerock.files import write_text
from freerock.jobs.home import PACKAGE
from freerock.jobs.reruns import code_files
from freerock_bench import campaigns
from freerock_bench.document import in_markdown, renew
from freerock_bench.gallery import IMAGES, in_few_colours
from freerock_bench.size import lines_of_code

ROOT = campaigns.ROOT
DOCUMENT, FOLDER, SMALL = ROOT / "docs/evidence.md", ROOT / "docs/evidence", Path("results/evidence")
WORKFLOW = ("freerock.jobs.make_record", "freerock.jobs.make_fits", "freerock.jobs.make_tables")
STUDIES = {  # by the name of its module: what a study judges
    "integrator": ("freerock.models.simulate",),
    "speed_accuracy": ("freerock.models.simulate",),
    "stability": ("freerock.models.simulate",),
    "minimum": ("freerock.identification.paper_fit",),
    "means": ("freerock.populations.means",),
    "by_hand": ("freerock.selection.loaded_record",),
    "scale": WORKFLOW,
    "scatter": WORKFLOW,
    "noises": WORKFLOW,
    "kinds": WORKFLOW,
    "realistic": WORKFLOW,
    "foreign": WORKFLOW,
}
FIGURES = {"speed_accuracy": ["speed_accuracy"], "stability": ["stability"]}
FIGURES["scatter"] = ["coverage", "parsimony"]
HEADING = re.compile(r"# SIMULATED: freerock (\S+), seed (\d+), code (\w+), rows (\w+)\n")
CITED = re.compile(r"<!--(\w+)-->([^<]*)<!--/-->")
STATISTICS: dict[str, Callable[[pd.DataFrame], str]] = {  # what a number says of its rows
    "inside": lambda rows: f"{rows['inside'].sum():.0f} of {len(rows)}",
    "percent": lambda rows: f"{100 * rows['inside'].mean():.0f} %",
    "rows": lambda rows: f"{len(rows):,}".replace(",", " "),
    "error": lambda rows: f"{100 * (rows['value'] / rows['truth'] - 1).abs().median():.2g} %",
    "times": lambda rows: f"{_times(rows):.2g}",
    "median": lambda rows: f"{rows['value'].median():.3g}",
    "median percent": lambda rows: f"{100 * rows['value'].median():.3g} %",
    "least": lambda rows: f"{rows['value'].min():.3g}",
    "verdict": lambda rows: str(rows["note"].iloc[0]).split()[0],
}


class Heading(NamedTuple):
    """What the first line of a table states."""

    version: str
    seed: str
    code: str
    rows: str


def main(*names: str, size: str = "full", cores: int = 2) -> None:
    """Make studies, then renew the documentation."""
    folder = FOLDER if size == "full" else SMALL
    for name in [each for each in STUDIES if each in names or (not names and is_older(each, folder))]:
        study = import_module(f"freerock_bench.{name}")
        own = code(f"freerock_bench.{name}", *STUDIES[name])  # what is there is of this code
        frame = study.run(size, Path("results/studies", name, size, own).resolve(), cores)
        write(name, frame, study.SEED, folder)
        for figure in FIGURES.get(name, ()) if size == "full" else ():
            draw(figure, frame)
        print(f"{name}\n\n{study.markdown(frame)}\n", flush=True)
    if size == "full":
        renew_documents()


def draw(name: str, frame: pd.DataFrame) -> None:
    """Draw a figure of a study, page by page, for the documentation."""
    figure = import_module(f"freerock_bench.figures.{name}")
    for page in getattr(figure, "PAGES", [""]):
        stem = Path("results/studies", name, f"{name}_{page}".strip("_"))
        drawn, rows = figure.draw(frame, *filter(None, [page]))
        save(drawn, rows, stem)
        in_few_colours(stem.with_suffix(".png"), IMAGES / f"studies_{stem.name}.png")


def write(name: str, frame: pd.DataFrame, seed: int, folder: Path = FOLDER) -> None:
    """Write a study's table below the line that says what it is."""
    rows = frame.to_csv(index=False, float_format="%.6g", lineterminator="\n")
    stated = Heading(version("freerock"), str(seed), code(*STUDIES[name]), _sum(rows))
    folder.mkdir(parents=True, exist_ok=True)
    text = "# SIMULATED: freerock {}, seed {}, code {}, rows {}\n".format(*stated)
    write_text(folder / f"{name}.csv", text + rows)


def heading(name: str, folder: Path = FOLDER) -> Heading:
    """What a study's table states of itself.

    Raises
    ------
    FreerockError
        There is no such table, or it states nothing.
    """
    path = folder / f"{name}.csv"
    found = HEADING.match(path.read_text(encoding="utf-8")) if path.is_file() else None
    if not found:
        raise FreerockError(path, "is no table of a study", f"run python -m freerock_bench.evidence {name}")
    return Heading(*found.groups())


def table(name: str, folder: Path = FOLDER) -> pd.DataFrame:
    """The rows of a study.

    Raises
    ------
    FreerockError
        A cell is another than the study wrote; the message names what rests on it.
    """
    path, stated = folder / f"{name}.csv", heading(name, folder)
    rows = path.read_text(encoding="utf-8").partition("\n")[2]
    if _sum(rows) != stated.rows:
        own = {row["name"] for row in numbers() if row["study"] == name}
        resting = dict.fromkeys(where for page in pages() for each, _, where in cited(page) if each in own)
        what = f"a cell was changed by hand; on it rest {'; '.join(resting) or 'no texts'}"
        raise FreerockError(path, what, f"run python -m freerock_bench.evidence {name}")
    return pd.read_csv(io.StringIO(rows))


def is_older(name: str, folder: Path = FOLDER) -> bool:
    """Whether a table is missing, or of other code than the present one."""
    return not (folder / f"{name}.csv").is_file() or heading(name, folder).code != code(*STUDIES[name])


def code(*modules: str) -> str:
    """Checksum of modules and of all that they import; comments, docstrings and blank lines do not count."""
    files = code_files(PACKAGE / "errors.py", *modules)
    texts = []
    for short, path in sorted(files.items()):
        lines = Path(path).read_text(encoding="utf-8").splitlines()
        kept = sorted(lines_of_code(Path(path))) if path.endswith(".py") else range(1, len(lines) + 1)
        texts += [short, *(lines[i - 1] for i in kept)]
    return _sum("\n".join(texts))


def _times(rows: pd.DataFrame) -> float:
    """How many times the median error of one of two groups is that of the other."""
    error = (rows["value"] / rows["truth"] - 1).abs().groupby([rows["case"], rows["parameter"]]).median()
    return float(error.max() / error.min())


def _sum(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def numbers() -> list[dict[str, str]]:
    """Name, printed text, study, rows, statistic and command of each number that may be cited."""
    with open(FOLDER / "numbers.csv", encoding="utf-8", newline="") as file:
        return [*csv.DictReader(file)]


def printed(number: dict[str, str]) -> str:
    """The text of a number, from the rows of its study."""
    frame = table(number["study"])
    return STATISTICS[number["statistic"]](
        frame.query(number["rows"], engine="python") if number["rows"] else frame
    )


def pages() -> list[Path]:
    """The texts that may cite numbers."""
    return [ROOT / "README.md", ROOT / "paper.md", *sorted((ROOT / "docs").rglob("*.md"))]


def cited(page: Path) -> list[tuple[str, str, str]]:
    """Name and text of each number that a page cites, and the line where it stands, after its place."""
    found = []
    for i, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        where = f"{page.name}:{i}: " + CITED.sub(lambda each: each[2], line)
        found += [(name, text, where) for name, text in CITED.findall(line)]
    return found


def renew_documents() -> None:
    """Write numbers, citations and tables of the documentation from the tables of the studies."""
    command = "python -m freerock_bench.evidence {study}"
    made = [row | {"printed": printed(row), "command": command.format(**row)} for row in numbers()]
    lines = io.StringIO()
    out = csv.DictWriter(lines, [*made[0]], lineterminator="\n")
    out.writeheader()
    out.writerows(made)
    write_text(FOLDER / "numbers.csv", lines.getvalue())
    texts = {number["name"]: number["printed"] for number in made}
    for page in pages():
        old = page.read_text(encoding="utf-8")
        new = CITED.sub(lambda found: f"<!--{found[1]}-->{texts[found[1]]}<!--/-->", old)
        if new != old:
            write_text(page, new)
    for name, text in sections():
        renew(DOCUMENT, name, text)


def listing() -> str:
    """A row per number that is cited, in the order of pages: of which rows of which table it is made."""
    where, of = dict[str, list[str]](), {number["name"]: number for number in numbers()}
    for page in pages():
        for name, *_ in cited(page):
            where.setdefault(name, []).append(page.name)
    rows = []
    for name, found in where.items():
        number = of[name]
        shown = f'<a id="{name}"></a>{number["printed"]}'
        query = f"`{number['rows']}`".replace("|", "\\|") if number["rows"] else "all"
        rows.append([", ".join(dict.fromkeys(found)), shown, number["statistic"], query, number["study"]])
    return in_markdown(["page", "number", "statistic", "of rows", "of table"], rows)


def sections() -> Iterator[tuple[str, str]]:
    """Name and text of each table of docs/evidence.md, below a line that says of which code it is."""
    yield "numbers", listing()
    for name in STUDIES:
        stated = heading(name)
        made = f"Made with version {stated.version}, seed {stated.seed}, of code `{stated.code}`."
        older = " **The code that it judges is newer.**" if is_older(name) else ""
        study: Any = import_module(f"freerock_bench.{name}")
        yield name, f"{made}{older}\n\n{study.markdown(table(name))}"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m freerock_bench.evidence")
    parser.add_argument(
        "studies", nargs="*", help=f"of {', '.join(STUDIES)}; by default those that are older"
    )
    parser.add_argument("--size", default="full", choices=["full", "small"])
    parser.add_argument("--cores", type=int, default=2)
    given = parser.parse_args()
    sys.exit(exit_code(lambda: main(*given.studies, size=given.size, cores=given.cores)))
