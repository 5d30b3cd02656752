"""The code whose checksum is a parameter of a step is the code that the step runs."""

import re
from pathlib import Path

import pytest
from small_campaign import ROOT

from freerock.figures.listed import FIGURES
from freerock.jobs import reruns
from freerock.jobs.reruns import code_checksum, code_files

SCRIPTS = {path.name for path in (ROOT / "workflow/scripts").glob("*.py") if "study" not in path.name}


@pytest.fixture(autouse=True)
def afresh(tmp_path, monkeypatch):
    """Nothing is known of any file, and what is found is written to no folder of the project."""
    monkeypatch.setattr(reruns, "NOTES", tmp_path / "notes.json")
    forget()


def forget():
    for cached in (code_checksum, reruns._known, reruns._notes):
        cached.cache_clear()


def test_every_module_a_step_imports_is_among_its_code(finished):
    """Against sys.modules at the end of each script of a real run."""
    seen = set()
    for trace in (finished / "trace").iterdir():
        script = re.match(r".*\.py", trace.name)[0]
        seen.add(script)
        imported = {
            Path(path).relative_to(finished / "src").as_posix() for path in trace.read_text().split("\n")
        }
        drawn = [f"freerock.figures.{each}" for each in FIGURES if f"freerock/figures/{each}.py" in imported]
        assert len(drawn) == (script == "figure.py")  # it imports the one that its rule names
        assert imported <= {*code_files(ROOT / "workflow/scripts" / script, *drawn)}, script
    assert seen == SCRIPTS


def checksum_of(path, text):
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    forget()
    return code_checksum(path)


WHOLE = '''"""A script."""

most = 12.5  # percent


def inside(value):
    """Whether."""
    return value < most
'''


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        ("A script.", "A good script.", True),
        ("  # percent", "", True),
        ('    """Whether."""\n', "", True),
        ("12.5", "12.50", True),
        ("inside(value)", "inside(\n    value,\n)", True),
        ("12.5", "12.6", False),
        ("value < most", "value <= most", False),
        ("inside(value)", "within(value)", False),
        ('"""A script."""\n', '"""A script."""\nimport freerock.units\n', False),
    ],
)
def test_what_counts_as_an_edit(tmp_path, old, new, same):
    one = checksum_of(tmp_path / "one/script.py", WHOLE)
    assert (checksum_of(tmp_path / "other/script.py", WHOLE.replace(old, new, 1)) == one) is same


def test_a_number_in_an_imported_module_is_an_edit(tmp_path, monkeypatch):
    package = tmp_path / "src/freerock"
    package.mkdir(parents=True)
    monkeypatch.setattr(reruns, "SOURCES", package.parent)
    for name, text in (
        ("__init__", ""),
        ("a", "from freerock import b\n"),
        ("b", "x = 1\n"),
        ("c", "y = 1\n"),
    ):
        (package / f"{name}.py").write_text(text)
    script, told = tmp_path / "script.py", []
    for name, text in (("b", "x = 1\n"), ("c", "y = 2\n"), ("b", "x = 22\n")):
        reruns._files_of.cache_clear()
        (package / f"{name}.py").write_text(text)
        told.append(checksum_of(script, "import freerock.a\n"))
    reruns._files_of.cache_clear()
    assert told[0] == told[1] != told[2]


@pytest.mark.parametrize(
    ("text", "modules"),
    [
        ("from freerock import files, units", {"files", "units"}),
        ("import freerock.rotation.sensor as beam, freerock.units", {"sensor", "units"}),
        ("def late():\n    from freerock.rotation.sensor import Laser\n", {"sensor"}),
        ("try:\n    import freerock.files\nexcept ImportError:\n    pass", {"files"}),
        ("if TYPE_CHECKING:\n    import freerock.files\n\nimport freerock.units", {"units"}),
    ],
)
def test_forms_of_imports(tmp_path, text, modules):
    statements = reruns._statements(reruns.ast.parse(text))
    names = {name for each in statements for name in reruns._imported(each)}
    files = {Path(path).stem for name in names for path in reruns._files_of(name)}
    assert files == {"__init__", *modules}
