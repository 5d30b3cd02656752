"""A small campaign on a real Slurm of two nodes: the bytes of a local run, also when a node dies.

Alone: make test-cluster
"""

import os
import shutil
import subprocess
import sys

import pytest
from slurm import missing, slurm
from small_campaign import CAMPAIGN, add_campaign, check_out, simulated

from freerock.virtual_lab.write_tdms import write_records

if missing():
    pytest.skip(f"not installed: {', '.join(missing())}", allow_module_level=True)

PROFILE = ["--group-components", "test=1"]  # a record a job, so that each node has one
PROFILE += ["--profile", "profiles/slurm", "--slurm-init-seconds-before-status-checks", "2"]
TESTS = ["one", "two"]


@pytest.fixture(scope="module")
def local(tmp_path_factory):
    """The campaign, analysed without a cluster."""
    checkout = check_out(tmp_path_factory.mktemp("local"))
    yaml = CAMPAIGN
    add_campaign(checkout, "small", yaml, [(test, "", "squat") for test in TESTS])
    write_records(checkout / "raw/small", [(test, simulated("squat", i)) for i, test in enumerate(TESTS)])
    done = checkout.snakemake()
    assert done.returncode == 0, done.stderr
    return checkout


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with slurm(tmp_path_factory.mktemp("slurm")) as running:
        yield running


@pytest.fixture
def remote(local, tmp_path):
    """The same campaign, not analysed yet."""
    shutil.copytree(local.folder, tmp_path / "remote", ignore=shutil.ignore_patterns("results", ".snakemake"))
    return type(local)(tmp_path / "remote")


def started(checkout, cluster, *targets):
    """Snakemake on the cluster, under way."""
    environment = os.environ | {"PYTHONPATH": str(checkout / "src")} | cluster.environment
    return subprocess.Popen(
        [sys.executable, "-m", "snakemake", *PROFILE, *targets],
        cwd=checkout.folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def test_two_nodes_give_the_bytes_of_a_local_run(local, remote, cluster):
    run = started(remote, cluster)
    told, _ = run.communicate()
    assert run.returncode == 0, told
    assert set(cluster.jobs()) == {"n1", "n2"}
    assert remote.products() == local.products()


def test_a_node_that_dies_midway_changes_no_byte(local, remote, cluster):
    """Slurm starts its job again, on whichever node is there; the run goes on without help."""
    fits = [path for path in local.products() if "/fits/" in path]
    run = started(remote, cluster, *fits)
    begun = remote / "results/small/logs/fit_one.log"
    cluster.wait_for(lambda: begun.exists() and "n2" in cluster.jobs("RUNNING"), 120)
    cluster.kill("n2")
    cluster.start_node("n2")
    told, _ = run.communicate()
    assert run.returncode == 0, told
    assert not list((remote / "results").rglob("*.partial*"))
    made = remote.products()
    assert set(fits) <= set(made)
    assert {path: local.products()[path] for path in made} == made
