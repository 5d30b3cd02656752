"""A stretch and an impact left out in the campaign's CSV: what the workflow makes of them, and what stays."""

import re

import numpy as np
import pandas as pd

from freerock.products.netcdf import open_record

CSV = "config/campaigns/small.csv"
WHY = "the cable was hit"


def restitution(checkout):
    table = pd.read_csv(checkout / "results/small/tables/restitution.csv", comment="#")
    return table[table["source"] == "experiment"].set_index(["test", "run", "impact"])["r"]


def test_from_the_csv_to_the_report(checkout):
    before, products = restitution(checkout), checkout.products()
    run = open_record(checkout / "results/small/records/tall_mat.nc")["run_1"].dataset
    second, fourth = run["impact_time"].values[[1, 3]]
    cell = f"{fourth - 0.01:.3f}:{fourth + 0.02:.3f};@{second:.4f}"
    checkout.edit(CSV, "tall,mat,high,,,,", f"tall,mat,high,{cell},,{WHY},")
    done = checkout.snakemake()
    assert done.returncode == 0, done.stderr
    after = restitution(checkout)
    assert after.index.equals(before.index)
    gone = after.index[after.isna()]
    assert gone.tolist() == [("tall_mat", 1, impact) for impact in (2, 3, 4, 5)]
    kept = after.notna()
    assert np.abs(after[kept] - before[kept]).max() < 0.01
    table = pd.read_csv(checkout / "results/small/tables/restitution_comparison.csv", comment="#")
    own = table.set_index("test")["r_median"]
    assert own["tall_mat"] == after["tall_mat"].median() != before["tall_mat"].median()
    runs = pd.read_csv(checkout / "results/small/tables/runs.csv", comment="#").set_index("test")
    told = (
        f"{fourth - 0.01:.3f} s to {fourth + 0.02:.3f} s left out: {WHY}; impact 2 at {second:.3f} s left out"
    )
    assert runs["reasons"]["tall_mat"].startswith(told) and runs["verdict"]["tall_mat"] == "ok"
    assert runs["n_restitution"]["tall_mat"] == after["tall_mat"].notna().sum()
    page = (checkout / "results/small/report.html").read_text()
    assert told in page and cell in page
    for name in ("records/squat_mat.nc", "fits/squat_mat.nc"):
        assert checkout.products()[f"results/small/{name}"] == products[f"results/small/{name}"]
    checkout.edit(CSV, f"{cell},,{WHY},", ",,,")
    assert checkout.snakemake("results/small/tables/runs.csv").returncode == 0
    again = checkout.products()
    made = [path for path in products if re.search(r"/(records|fits)/|/tables/(runs|restitution)\.csv", path)]
    assert len(made) == 6 and all(again[path] == products[path] for path in made)
    assert not {"record", "fit", "tables"} & checkout.planned().keys()


def test_what_is_not_there_is_told_in_a_line_each(checkout):
    checkout.edit(CSV, "tall,mat,high,,,,", f"tall,mat,high,500:501;@500,,{WHY},")
    done = checkout.snakemake("results/small/tables/runs.csv", "--config", "campaigns=[small]")
    assert done.returncode == 0, done.stderr
    runs = pd.read_csv(checkout / "results/small/tables/runs.csv", comment="#").set_index("test")
    lines = runs["reasons"]["tall_mat"].split("; ")
    assert lines[0].startswith("exclude: 500 s to 501 s meets no run: they last from ")
    assert lines[1].startswith("exclude: there is no impact at 500 s: the nearest is at ")
    assert runs["verdict"]["tall_mat"] == "warn"
