"""Fixtures: a finished campaign, and copies of it to be changed."""

import os

import pandas as pd
import pytest
from small_campaign import (
    BLOCKS,
    BY,
    CAMPAIGN,
    TRACE,
    Checkout,
    add_campaign,
    check_out,
    copied,
    once,
    simulated,
)

from freerock.virtual_lab.write_tdms import write_records


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """A campaign of two records, analysed; with the package's files each script imported in `trace`."""

    def analyse(folder):
        checkout = check_out(folder)
        add_campaign(checkout, "small", CAMPAIGN + BY, [("tall_mat", "", "tall"), ("squat_mat", "", "squat")])
        records = [(f"{block}_mat", simulated(block, seed)) for seed, block in enumerate(BLOCKS)]
        write_records(checkout / "raw/small", records)
        for part in ("hook", "trace"):
            (checkout / part).mkdir()
        (checkout / "hook/sitecustomize.py").write_text(TRACE)
        path = os.pathsep.join(str(checkout / part) for part in ("src", "hook"))
        done = checkout.snakemake(PYTHONPATH=path, TRACE=str(checkout / "trace"))
        assert done.returncode == 0, done.stderr

    return Checkout(once(tmp_path_factory, "finished", analyse))


@pytest.fixture(scope="module")
def tables(results):
    """The tidy tables, by name, of the `results` of a module's own campaign."""
    return {each.stem: pd.read_csv(each) for each in (results / "tables").glob("*.csv")}


@pytest.fixture
def checkout(finished, tmp_path):
    """A copy of the finished campaign, to be changed."""
    return Checkout(copied(finished.folder, tmp_path / "copy"))
