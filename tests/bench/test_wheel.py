"""The wheel holds what a laboratory runs; the checkout, installed as editable, the bench as well."""

import shutil
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[2]


def test_a_wheel_holds_the_product_alone(tmp_path):
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy2(ROOT / name, tmp_path)
    shutil.copytree(ROOT / "src", tmp_path / "src", ignore=shutil.ignore_patterns("__pycache__"))
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "."]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (wheel,) = tmp_path.glob("*.whl")
    held = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    product = (ROOT / "src/freerock").rglob("*")
    files = {path.relative_to(ROOT / "src").as_posix() for path in product if path.is_file()}
    assert held == {name for name in files if "__pycache__" not in name}


def test_the_checkout_has_the_bench():
    assert Path(find_spec("freerock_bench").origin) == ROOT / "src/freerock_bench/__init__.py"
