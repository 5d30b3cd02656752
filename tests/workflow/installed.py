"""freerock as `pip install` lays it down, in a folder of its own: a wheel built from the sdist."""

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCES = ("src", "workflow", "profiles", "Snakefile", "pyproject.toml", "setup.py", "MANIFEST.in")
SOURCES += ("requirements.lock", "Makefile", "LICENSE", "README.md")

LEFT_OUT = shutil.ignore_patterns("__pycache__", "*.egg-info")


def run(command, folder):
    done = subprocess.run([sys.executable, *map(str, command)], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def wheel_from_sdist(folder: Path) -> Path:
    """The wheel, built without the checkout at hand."""
    copy = folder / "copy"
    copy.mkdir()
    for name in SOURCES:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, copy / name, ignore=LEFT_OUT)
        else:
            shutil.copy2(ROOT / name, copy)
    run(["-c", "from setuptools.build_meta import build_sdist; build_sdist('dist')"], copy)
    (sdist,) = (copy / "dist").glob("*.tar.gz")
    options = ["--quiet", "--disable-pip-version-check", "--no-deps", "--no-build-isolation"]
    run(["-m", "pip", "wheel", *options, "--wheel-dir", folder / "wheel", sdist], folder)
    (wheel,) = (folder / "wheel").glob("*.whl")
    return wheel


def install(folder: Path) -> Path:
    """A folder for PYTHONPATH with freerock as a wheel installs it."""
    options = ["--quiet", "--disable-pip-version-check", "--no-deps", "--no-compile"]
    run(["-m", "pip", "install", *options, "--target", folder / "site", wheel_from_sdist(folder)], folder)
    return folder / "site"
