"""A laboratory's own folder beside an installed freerock: analysed as in a checkout."""

import os
import shutil
import subprocess
from importlib.metadata import version

import pytest
from installed import install
from small_campaign import Checkout, once
from warm import commands

pytestmark = pytest.mark.slow


class Laboratory(Checkout):
    """A folder with the files of `freerock init`, a campaign, and freerock installed elsewhere."""

    def __init__(self, folder, site):
        super().__init__(folder)
        self.site = site

    def snakemake(self, *arguments, **environment):
        return super().snakemake(*arguments, **{"PYTHONPATH": str(self.site)} | environment)

    def freerock(self, *arguments):
        environment = os.environ | {"PYTHONPATH": str(self.site)}
        command = [commands() / "freerock", *map(str, arguments)]
        return subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True)


def share_compiled(one, other):
    """Have the same code compiled in one place count in another; numba goes by the times of files."""
    for path in other.rglob("*.py"):
        source = one / path.relative_to(other)
        if source.exists() and path.read_bytes() == source.read_bytes():
            shutil.copystat(source, path)
    for folder in one.rglob("__pycache__"):
        shutil.copytree(folder, other / folder.relative_to(one), dirs_exist_ok=True)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    return once(tmp_path_factory, "installed", install) / "site"


@pytest.fixture(scope="module")
def analysed(finished, site, tmp_path_factory):
    """The campaign of `finished`, analysed in a laboratory's own folder."""
    laboratory = Laboratory(tmp_path_factory.mktemp("own"), site)
    share_compiled(finished / "src/freerock", site / "freerock")
    done = laboratory.freerock("init")
    assert done.returncode == 0, done.stderr
    shutil.copytree(finished / "raw/small", laboratory / "raw/small")
    shutil.copytree(finished / "config/campaigns", laboratory / "config/campaigns")
    laboratory.edit("config/config.yaml", "campaigns: []", "campaigns: [small]")
    done = laboratory.snakemake()
    assert done.returncode == 0, done.stderr
    return laboratory


def test_the_folder_holds_what_version_control_needs(analysed):
    assert (analysed / "requirements.txt").read_text().startswith("freerock==")
    assert "results/" in (analysed / ".gitignore").read_text().splitlines()
    told = analysed.freerock("init")
    assert told.returncode == 0
    assert "written: nothing" in told.stdout and "kept:    Snakefile" in told.stdout


def test_the_same_bytes_as_in_a_checkout(finished, analysed):
    products, own = finished.products(), analysed.products()
    assert own.keys() == products.keys()
    state = f"freerock {version('freerock')} as installed".encode()
    assert state in own["results/small/tables/methods.md"]
    assert [name for name in products if own[name] != products[name]] == []
