"""The cache of machine code holds it under the name of all that shapes it."""

import os
import re
import shutil
from pathlib import Path

import numba
import pytest

from freerock.models import compiled

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


KERNEL = """\
from freerock.models.compiled import compiled


@compiled()
def twice(x):
    return 2 * x


@compiled()
def four_times(x):
    return 2 * twice(x)
"""


def loaded(room):
    """The functions of a kernel, as another process would have them."""
    file = str(room / "kernel.py")
    Path(file).write_text(KERNEL)
    os.utime(file, (1e9, 1e9))
    names = {"__name__": "kernel", "__file__": file}
    exec(compile(KERNEL, file, "exec"), names)
    return names["four_times"], names["twice"]


def compilations(function):
    return sum(function.stats.cache_misses.values())


def test_files_of_the_cache_have_this_name(room):
    _, twice = loaded(room)
    assert twice(2) == 4
    (index,) = room.glob("__pycache__/*.nbi")
    assert re.fullmatch(rf"kernel\.twice_{identity(room)}-.*\.nbi", index.name)


def flipped(data):
    return data[:-9] + bytes([data[-9] ^ 1]) + data[-8:]


@pytest.mark.parametrize("suffix", ["nbi", "nbc", "sha256"])
@pytest.mark.parametrize("damage", [flipped, lambda data: data[:20], lambda data: b"", None])
def test_damaged_machine_code_is_compiled_again(room, suffix, damage):
    """Of the function that is called, and of one that it calls, when it must be compiled itself."""
    assert loaded(room)[0](2) == 8
    function, _ = loaded(room)
    assert function(2) == 8 and compilations(function) == 0
    for path in room.glob(f"__pycache__/*.{suffix}"):
        path.write_bytes(damage(path.read_bytes())) if damage else path.unlink()
    both = loaded(room)
    assert both[0](2) == 8 and both[1](2) == 4
    assert [compilations(each) for each in both] == [1, 1]
    function, _ = loaded(room)
    assert function(2) == 8 and compilations(function) == 0


def test_machine_code_of_another_function_is_compiled_again(room):
    assert loaded(room)[0](2) == 8
    one, other = sorted(room.glob("__pycache__/*.nbc"))
    one.write_bytes(other.read_bytes())
    assert loaded(room)[0](2) == 8


@pytest.mark.parametrize("path", KERNELS, ids=lambda path: path.stem)
def test_kernels_take_constants_only_from_where_the_name_covers_them(path):
    imported = re.findall(r"^(?:from|import) (freerock[\w.]*)", path.read_text(encoding="utf-8"), re.M)
    assert {name for name in imported if not name.startswith("freerock.models")} <= {"freerock.arrays"}
