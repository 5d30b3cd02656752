"""import freerock: the public names and no others, and nothing loaded for it."""

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import freerock

ROOT = Path(__file__).parents[2]
RUN = {"capture_output": True, "text": True, "check": True}


def python(code):
    return subprocess.run([sys.executable, "-c", code], **RUN).stdout.strip()


def test_the_public_names_are_those_that_are_listed():  # tests/docs/test_site.py: each is on the site
    assert set(freerock.__all__) == set(dir(freerock))
    assert len(freerock.__all__) == len(set(freerock.__all__))


def test_each_name_is_there_and_described():
    for name in freerock.__all__:
        found = getattr(freerock, name)
        assert inspect.isclass(found) or inspect.isfunction(found)
        assert inspect.getdoc(found)


def test_no_other_name():
    with pytest.raises(AttributeError, match="has no attribute 'fit_runs'"):
        freerock.fit_runs  # noqa: B018


def test_nothing_is_loaded_before_it_is_used():
    heavy = "{'numpy', 'yaml', 'pydantic', 'scipy', 'xarray'}"
    assert python(f"import freerock, sys; print({heavy} & {{*sys.modules}} or '')") == ""
    assert python("import freerock, sys; freerock.Block; print('numpy' in sys.modules)") == "False"


def test_a_name_does_not_depend_on_what_was_imported_before():
    code = "import freerock.rotation.rotation, freerock.models.simulate, freerock.planning.plan; "
    code += "import freerock; "
    assert python(f"{code} print(all(callable(getattr(freerock, n)) for n in freerock.__all__))") == "True"


def test_type_checkers_see_the_same_names():
    text = (ROOT / "src/freerock/__init__.py").read_text(encoding="utf-8")
    hints = text.partition("if TYPE_CHECKING:\n")[2].partition("\n\n")[0]
    names = {
        word.split(" as ")[-1].strip()
        for line in hints.splitlines()
        for word in line.partition(" import ")[2].split(",")
    }
    assert names == set(freerock.__all__)
    assert (ROOT / "src/freerock/py.typed").exists()
