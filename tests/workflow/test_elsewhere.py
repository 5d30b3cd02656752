"""Other ways to use the workflow: another working directory, chosen campaigns, as a module."""

import re
import shutil

import pytest
from small_campaign import Checkout

RECORD = "results/small/records/squat_mat.nc"


@pytest.fixture
def laboratory(finished, tmp_path):
    """A folder with a laboratory's config and records, and nothing of freerock."""
    for part in ("config", "raw"):
        shutil.copytree(finished / part, tmp_path / "laboratory" / part)
    return Checkout(tmp_path / "laboratory")


def test_directory(finished, laboratory):
    done = finished.snakemake("--directory", laboratory.folder, RECORD)
    assert done.returncode == 0, done.stderr
    assert (laboratory / RECORD).read_bytes() == (finished / RECORD).read_bytes()


def test_module(finished, laboratory):
    (laboratory / "config/config.yaml").unlink()
    (laboratory / "Snakefile").write_text(
        f"""
module freerock:
    snakefile: "{finished / "Snakefile"}"
    config: {{"campaigns": ["small"]}}

use rule * from freerock as freerock_*
"""
    )
    done = laboratory.snakemake(RECORD, PYTHONPATH=str(finished / "src"))
    assert done.returncode == 0, done.stderr
    assert (laboratory / RECORD).read_bytes() == (finished / RECORD).read_bytes()


@pytest.mark.parametrize(
    ("choice", "names"),
    [
        ("campaigns=other", {"other"}),
        ("campaigns=[other]", {"other"}),
        ("campaigns=small,other", {"small", "other"}),
    ],
)
def test_campaigns_chosen_on_the_command_line(checkout, choice, names):
    for suffix in ("yaml", "csv"):
        shutil.copy(
            checkout / f"config/campaigns/small.{suffix}", checkout / f"config/campaigns/other.{suffix}"
        )
    shutil.copytree(checkout / "raw/small", checkout / "raw/other")
    shutil.rmtree(checkout / "results")
    done = checkout.snakemake("--dry-run", "--config", choice)
    assert set(re.findall(r"results/(\w+)/complete.txt", done.stdout + done.stderr)) == names
