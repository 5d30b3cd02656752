"""The code whose checksum is a parameter of a step is the code the step runs."""

import ast
import os
import re
import shutil
from pathlib import Path

import pytest
from small_campaign import ROOT

from freerock.config.figure_names import FIGURES
from freerock.jobs import code_identity as workflow
from freerock.jobs.code_identity import code, code_checksum

SCRIPTS = {path.name for path in (ROOT / "workflow/scripts").glob("*.py") if "study" not in path.name}


def test_every_module_a_step_imports_is_among_its_code(finished, checkout):
    """Against sys.modules at the end of each script of a real run, and of figures drawn by name."""
    shutil.rmtree(checkout / "trace")
    (checkout / "trace").mkdir()
    path = os.pathsep.join(str(checkout / part) for part in ("src", "hook"))
    wanted = [f"results/small/figures/{name}.pdf" for name in ("models", "residuals", "predictions")]
    done = checkout.snakemake(*wanted, PYTHONPATH=path, TRACE=str(checkout / "trace"))
    assert done.returncode == 0, done.stderr
    seen = set()
    traces = [(each, trace) for each in (finished, checkout) for trace in (each / "trace").iterdir()]
    assert len({trace.name for each, trace in traces if each is checkout}) == len(wanted)
    for each, trace in traces:
        script = re.match(r".*\.py", trace.name)[0]
        seen.add(script)
        imported = {Path(path).relative_to(each.folder) for path in trace.read_text().split("\n")}
        figures = {path.stem for path in imported if path.parent.name == "figures"} - {
            *("__init__", "style", "looks"),
        }
        named = [f"freerock.figures.{name}" for name in FIGURES if name in figures and script == "figure.py"]
        declared = {Path(path).relative_to(ROOT) for path in code(ROOT / "workflow/scripts" / script, *named)}
        assert imported <= declared, script
    assert seen == SCRIPTS


@pytest.mark.parametrize(
    "script", sorted((ROOT / "workflow/scripts").glob("*.py")), ids=lambda path: path.stem
)
def test_scripts_import_what_takes_long_at_work(script):
    first = ast.parse(script.read_text(encoding="utf-8")).body
    imported = [line.module for line in first if isinstance(line, ast.ImportFrom)]
    assert [name for name in imported if name.startswith("freerock")] == ["freerock.jobs.ledger"]


def test_imports_for_type_checkers_do_not_count(tmp_path):
    script = tmp_path / "script.py"
    script.write_text("from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from freerock import units\n")
    assert code(script) == [str(script)]


def test_checksum_counts_names_and_contents_not_times_and_folders(tmp_path):
    def checksum(path, text):
        script = tmp_path / path
        script.parent.mkdir(exist_ok=True)
        script.write_text(text)
        if "old" in path:
            os.utime(script, (0, 0))
        return code_checksum(script)

    told = checksum("here/script.py", "import freerock.units\n")
    assert checksum("old/script.py", "import freerock.units\n") == told
    assert checksum("here/another.py", "import freerock.units\n") != told
    assert checksum("edited/script.py", "import freerock.units as edited\n") != told


WHOLE = '''"""A module."""


class Limit:
    """A limit."""

    most = 12.5  # percent


def inside(value):
    """Whether a value is inside."""
    return -Limit.most < value < Limit.most
'''


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"""A module."""\n', ""),
        ("A limit.", "A limit of 13 percent."),
        ('    """A limit."""\n\n', ""),
        ("# percent", "# 13 percent"),
        ("\n\n\ndef inside(value):", "\ndef inside(\n    value,\n):"),
        ('    """Whether a value is inside."""\n', ""),
        ("12.5", "12.50"),
    ],
)
def test_what_means_the_same_is_the_same_code(tmp_path, old, new):
    assert meaning_of(tmp_path, WHOLE.replace(old, new)) == meaning_of(tmp_path, WHOLE)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("12.5", "12.6"),
        ("12.5", "'12.5'"),
        ("most = 12.5", "most = None"),
        ("-Limit.most", "+Limit.most"),
        ("< value <", "<= value <"),
        ("def inside(value)", "def inside(value=None)"),
        ("return -Limit", 'f"""Whether"""\n    return -Limit'),
        ("inside(value):", "within(value):"),
        ("return -Limit.most < value < Limit.most", "return"),
        ("return -Limit.most < value < Limit.most", "return None"),
        ("class Limit:", "@edited\nclass Limit:"),
    ],
)
def test_what_means_something_else_is_other_code(tmp_path, old, new):
    assert old in WHOLE
    assert meaning_of(tmp_path, WHOLE.replace(old, new)) != meaning_of(tmp_path, WHOLE)


def meaning_of(folder, text):
    workflow.meaning.cache_clear()
    (folder / "module.py").write_text(text)
    return workflow.meaning(str(folder / "module.py"))


def test_checksum_is_the_same_before_and_behind_the_package(tmp_path, monkeypatch):
    package = tmp_path / "m/freerock"
    package.mkdir(parents=True)
    (package / "__init__.py").touch()
    workflow._package.cache_clear()
    monkeypatch.setattr("freerock.jobs.code_identity.PACKAGE", package)
    told = set()
    for folder in ("a", "z"):
        script = tmp_path / folder / "script.py"
        script.parent.mkdir()
        script.write_text("import freerock\n")
        assert str(package / "__init__.py") in code(script)
        told.add(code_checksum(script))
    workflow._package.cache_clear()
    assert len(told) == 1


def test_checksum_counts_the_contents_of_modules(tmp_path, monkeypatch):
    package = tmp_path / "freerock"
    package.mkdir()
    monkeypatch.setattr("freerock.jobs.code_identity.PACKAGE", package)
    script = tmp_path / "script.py"
    script.write_text("import freerock.sensor\n")
    for name in ("__init__.py", "sensor.py", "another.py"):
        (package / name).touch()

    def checksum():
        for cached in (
            code_checksum,
            workflow._imported,
            workflow._package,
            workflow._line,
            workflow.meaning,
        ):
            cached.cache_clear()
        return code_checksum(script)

    told = checksum()
    (package / "another.py").write_text("edited = True\n")
    assert checksum() == told
    (package / "sensor.py").write_text("edited = True\n")
    assert checksum() != told
    monkeypatch.undo()
    checksum()
