"""Bugs put in on purpose, drawn by a seed over all rooms: how many do the tests of the changed module catch?

    python -m freerock_bench.mutation results/studies/mutation.csv 60 1

takes the number of mutants and the seed; 60 take two hours on one core. Each mutant changes one comparison,
operation, number, truth value or negation of one function of `freerock`, in a copy of the checkout. First run
tests that import the module; where these are few, those too of modules that import it, and of its room. What
they miss, the campaigns in `tests/workflow` whose numbers are kept may catch; without a bug these must pass.
Last run the tests of Snakemake and the browser that import the module. A mutant is caught when a test fails
or does not end. The rooms are drawn in turn, so that a large one has no more mutants than a small one.
Survivors are printed with their line; some change nothing that can be seen: a reader judges.
"""

import ast
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from freerock.errors import FreerockError
from freerock.tables.csvfile import write_csv

ROOT = Path(__file__).parents[2]
LEFT_OUT = (".git", ".venv*", ".snakemake", ".*_cache", "__pycache__", "src", "results", "build", "dist")
MADE = "results/palermo_virtual"  # by `make`; made again where a bug touches it
COLUMNS = ["room", "file", "line", "function", "before", "after", "caught", "by"]
LIMIT_S = 900  # of the tests of one mutant; a loop without end is caught
FAILED = (1, 2, 3)  # pytest's: a test, the collection, pytest itself
QUICK, SLOW = ("unit", "physics", "bench"), ("workflow", "browser")  # folders of tests
KEPT = ["tests/workflow", "-k", "as_kept"]  # campaigns whose numbers are kept
AT_ONCE = 6  # files of tests, those first that are named as the module
PAIRS: list[tuple[Any, Any]] = [(ast.Lt, ast.LtE), (ast.Gt, ast.GtE), (ast.Eq, ast.NotEq)]
PAIRS += [(ast.Add, ast.Sub), (ast.Mult, ast.Div), (ast.And, ast.Or)]
OTHER: dict[Any, Any] = {one: other for pair in PAIRS for one, other in (pair, pair[::-1])}


@dataclass(frozen=True)
class Mutant:
    """One change of a file: the text of an expression at its place, and what it becomes."""

    file: Path
    function: str
    node: ast.expr
    after: str

    @property
    def room(self) -> str:
        """The room of the file; "." of a file beside the rooms."""
        parts = self.file.relative_to(ROOT / "src/freerock").parts
        return parts[0] if len(parts) > 1 else "."

    @property
    def before(self) -> str:
        """The expression as it stands."""
        return ast.unparse(self.node)

    def text(self) -> str:
        """The file with the change."""
        lines = self.file.read_bytes().splitlines(keepends=True)
        first, last = self.node.lineno - 1, (self.node.end_lineno or self.node.lineno) - 1
        head = lines[first][: self.node.col_offset]
        tail = lines[last][self.node.end_col_offset :]
        changed = b"".join([*lines[:first], head, f"({self.after})".encode(), tail, *lines[last + 1 :]])
        return changed.decode("utf-8")


def mutants_of(file: Path) -> Iterator[Mutant]:
    """Every change that can be made in the functions of a file."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            told = {id(each) for each in ast.walk(function) if _is_wording(each) for each in ast.walk(each)}
            for node in ast.walk(function):
                if isinstance(node, ast.expr) and id(node) not in told and (after := changed(node)):
                    yield Mutant(file, function.name, node, after)


def _is_wording(node: ast.AST) -> bool:
    """Type hints and texts: no test should pin them."""
    return isinstance(node, ast.JoinedStr | ast.arg) or (
        isinstance(node, ast.AnnAssign) and node.value is None
    )


def changed(node: ast.expr) -> str:
    """What an expression becomes; "" of one that is left as it is."""
    match node:
        case ast.Compare(left, [operator], [right]) if type(operator) in OTHER:
            return ast.unparse(ast.Compare(left, [OTHER[type(operator)]()], [right]))
        case ast.BinOp(left, operator, right) if type(operator) in OTHER and not _has_text(left, right):
            return ast.unparse(ast.BinOp(left, OTHER[type(operator)](), right))
        case ast.BoolOp(operator, values):
            return ast.unparse(ast.BoolOp(OTHER[type(operator)](), values))
        case ast.UnaryOp(ast.Not() | ast.USub(), operand):
            return ast.unparse(operand)
        case ast.Constant(bool() as value):
            return str(not value)
        case ast.Constant(int() | float() as value):
            return str(value + 1 if isinstance(value, int) else 2 * value + 1)
    return ""


def _has_text(*nodes: ast.expr) -> bool:
    """Whether a text is joined, or a path: changed, it would not run at all."""
    texts = [each for each in nodes if isinstance(each, ast.Constant) and isinstance(each.value, str)]
    return bool(texts) or any(isinstance(each, ast.JoinedStr) for each in nodes)


def drawn_mutants(n: int, seed: int) -> list[Mutant]:
    """So many mutants, the rooms in turn."""
    draw = random.Random(seed)
    rooms: dict[str, list[Mutant]] = {}
    for file in sorted((ROOT / "src/freerock").rglob("*.py")):
        for mutant in mutants_of(file):
            rooms.setdefault(mutant.room, []).append(mutant)
    order = sorted(rooms)
    return [draw.choice(rooms[order[i % len(order)]]) for i in range(n)]


def tests_in(folders: Sequence[str]) -> dict[Path, set[str]]:
    """Test files of some folders, and what each imports."""
    paths = [path for name in folders for path in sorted((ROOT / "tests" / name).glob("test_*.py"))]
    return {path: imported(path) for path in paths}


def related_tests(file: Path) -> list[Path]:
    """Test files that import a module; of few, those too of modules that import it or are of its room."""
    tests, module = tests_in(QUICK), _module(file)
    users = {_module(path) for path in (ROOT / "src/freerock").rglob("*.py") if module in imported(path)}
    room = {_module(path) for path in file.parent.glob("*.py")}
    related: dict[Path, None] = {}
    for wanted in ({module}, users, room):
        if len(related) >= AT_ONCE:
            break
        own = [path for path, names in tests.items() if wanted & names]
        related |= dict.fromkeys(
            sorted(own, key=lambda test: (file.stem not in test.stem, test.stat().st_size))
        )
    return [*related] or [ROOT / "tests/unit/test_rooms.py"]


def _module(file: Path) -> str:
    return ".".join(file.relative_to(ROOT / "src").with_suffix("").parts)


def imported(file: Path) -> set[str]:
    """Modules that a file imports, and names from them as if they were modules."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{each.name}" for each in node.names)}
        elif isinstance(node, ast.Import):
            found |= {each.name for each in node.names}
    return found


def tried(mutant: Mutant, checkout: Path) -> dict[str, object]:
    """The row of a mutant, whose tests run in a copy of the checkout."""
    shutil.rmtree(checkout / "src", ignore_errors=True)
    shutil.copytree(ROOT / "src", checkout / "src")
    (checkout / mutant.file.relative_to(ROOT)).write_text(mutant.text(), encoding="utf-8")
    related = [str(path.relative_to(ROOT)) for path in related_tests(mutant.file)]
    quick = [related[i : i + AT_ONCE] for i in range(0, len(related), AT_ONCE)]
    by = next(filter(None, (caught_by(tests, checkout) for tests in (*quick, KEPT))), "")
    by = by or _caught_late(mutant, checkout)
    place = {"room": mutant.room, "file": str(mutant.file.relative_to(ROOT)), "line": mutant.node.lineno}
    change = {"function": mutant.function, "before": mutant.before, "after": mutant.after}
    return place | change | {"caught": bool(by), "by": by}


def _caught_late(mutant: Mutant, checkout: Path) -> str:
    """The first slow test of the module that fails, but passes without the bug; "" where none does."""
    for path, names in tests_in(SLOW).items():
        tests = [str(path.relative_to(ROOT))]
        if _module(mutant.file) in names and (by := caught_by(tests, checkout)):
            shutil.copy2(mutant.file, checkout / mutant.file.relative_to(ROOT))
            return "" if caught_by(tests, checkout) else by
    return ""


def caught_by(tests: Sequence[str], checkout: Path) -> str:
    """The first of some tests that fails, or that the tests do not end; "" where all pass."""
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:xdist", "-p", "no:cacheprovider"]
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": str(checkout / "src")}
    with subprocess.Popen(
        [*command, *tests],
        cwd=checkout,
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as run:
        try:
            told, _ = run.communicate(timeout=LIMIT_S)
        except subprocess.TimeoutExpired:
            os.killpg(run.pid, signal.SIGKILL)  # with the runs of Snakemake that it started
            return "no end"
    failed = [line for line in told.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return failed[0].split(" ")[1] if failed else "pytest" * (run.returncode in FAILED)


def main(product: str, n: str = "60", seed: str = "1") -> None:
    """Try mutants and write the table; the score is printed last."""
    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        checkout = Path(scratch)
        shutil.copytree(ROOT, checkout, ignore=shutil.ignore_patterns(*LEFT_OUT), dirs_exist_ok=True)
        if (ROOT / MADE).exists():
            shutil.copytree(ROOT / MADE, checkout / MADE)
        shutil.copytree(ROOT / "src", checkout / "src")
        if failed := caught_by(KEPT, checkout):
            raise FreerockError(failed, "fails without a bug", "mend it first")
        for mutant in drawn_mutants(int(n), int(seed)):
            rows.append(tried(mutant, checkout))
            row = rows[-1]
            told = "caught" if row["caught"] else "SURVIVED"
            print(f"{told}: {row['file']}:{row['line']} {row['before']} -> {row['after']}", flush=True)
    frame = pd.DataFrame(rows, columns=COLUMNS)
    write_csv(frame, Path(product))
    print(f"{frame['caught'].sum()} of {len(frame)} caught, {100 * frame['caught'].mean():.0f} %")


if __name__ == "__main__":
    main(*sys.argv[1:])
