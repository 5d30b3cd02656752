"""The cache of machine code holds it under the name of all that shapes it."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from freerock.models import compiled
from freerock.models.housner import _carlson

PACKAGE = Path(compiled.__file__).parents[1]
MODULES = PACKAGE.parent.rglob("*.py")
KERNELS = [path for path in MODULES if "\n@compiled(" in path.read_text(encoding="utf-8")]


@pytest.fixture
def room(tmp_path, monkeypatch):
    """A copy of the room of the models, and a kernel beside it."""
    shutil.copytree(PACKAGE / "models", tmp_path / "models")
    (tmp_path / "kernel.py").write_text("LIMIT = 1\n")
    monkeypatch.setattr(compiled, "__file__", str(tmp_path / "models/compiled.py"))
    return tmp_path


def identity(room):
    compiled.identity.cache_clear()
    try:
        return compiled.identity(str(room / "kernel.py"))
    finally:
        compiled.identity.cache_clear()


def edit(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


@pytest.mark.parametrize(
    "change",
    [
        lambda room, patch: edit(room / "models/compiled.py", '{"contract"}', "True"),
        lambda room, patch: edit(room / "models/block.py", "9.81", "9.82"),
        lambda room, patch: edit(room / "kernel.py", "1", "2"),
        lambda room, patch: patch.setattr(numba, "__version__", "0"),
        lambda room, patch: patch.setattr(compiled.llvmlite.binding, "get_host_cpu_name", lambda: "other"),
        lambda room, patch: patch.setenv("NUMBA_CPU_NAME", "generic"),
    ],
    ids=["options", "constant", "kernel", "numba", "processor", "asked for another processor"],
)
def test_what_shapes_machine_code_gives_it_another_name(room, monkeypatch, change):
    before = identity(room)
    assert identity(room) == before
    change(room, monkeypatch)
    assert identity(room) != before


@pytest.mark.parametrize("path", KERNELS, ids=lambda path: path.stem)
def test_kernels_take_constants_only_from_where_the_name_covers_them(path):
    imported = re.findall(r"^(?:from|import) (freerock[\w.]*)", path.read_text(encoding="utf-8"), re.M)
    assert {name for name in imported if not name.startswith("freerock.models")} <= {"freerock.arrays"}


LOADED = """
import sys, numba
from freerock.models.housner import _carlson
assert _carlson(4.0, 4.0, 4.0) == 0.5 and "numba.np.npyimpl" not in sys.modules
assert numba.njit(lambda x: _carlson(x, x, x))(4.0) == 0.5
"""


@pytest.mark.slow
def test_a_kernel_of_the_cache_is_loaded_without_what_compiling_needs_and_may_be_compiled_into_others():
    assert _carlson(4.0, 4.0, 4.0) == 0.5  # in the cache from here on
    subprocess.run([sys.executable, "-c", LOADED], check=True)
