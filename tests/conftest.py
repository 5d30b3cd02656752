"""Settings of all tests, and the shipped campaign, analysed once for those that look at its products."""

import shutil

import pytest
from hypothesis import settings
from small_campaign import ROOT, check_out

settings.register_profile("same every time", deadline=None, derandomize=True)
settings.load_profile("same every time")


@pytest.fixture(scope="session")
def palermo(tmp_path_factory):
    """The results of the shipped campaign, from record files to report."""
    checkout = check_out(tmp_path_factory.mktemp("palermo"))
    shutil.rmtree(checkout / "config")
    for part in ("config", "raw"):
        shutil.copytree(ROOT / part, checkout / part)
    done = checkout.snakemake()
    assert done.returncode == 0, done.stdout + done.stderr
    return checkout / "results/palermo_virtual"
