"""The shipped campaign, from record files to report."""

import doctest
import inspect
import json
import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from golden_numbers import differences
from small_campaign import ROOT

import freerock
from freerock.columns import columns_of
from freerock_bench.evidence import numbers

INPUTS = {"width": "width_m", "beam": "position_m", "height": "height_m", "scale": "scale_fraction"}
INPUTS |= {"centre of mass": "com_height_m", "inertia": "inertia_kg_m2", "runs": "runs"}


def table(palermo, name):
    return pd.read_csv(palermo / f"tables/{name}.csv", dtype={"run": str})


def test_tables_have_the_columns_other_peoples_scripts_rely_on(palermo):
    for path in sorted(palermo.glob("tables/*.csv")):
        assert list(pd.read_csv(path)) == columns_of(path.stem), path.name


def test_each_number_is_as_kept(palermo):
    assert differences(palermo, "palermo") == []


def test_every_run_of_every_record_is_found_and_called_simulated(palermo):
    runs = table(palermo, "runs")
    assert (runs.groupby("test")["run"].agg("".join) == "123").all()
    assert runs["test"].nunique() == 6
    assert set(runs["origin"]) == {"simulated"}
    assert set(runs["verdict"]) == {"ok"}


def test_the_squat_block_rocks_longest_on_marble_as_the_head_of_the_report_says(palermo):
    longest = table(palermo, "summary").set_index("foundation")["longest"]
    assert longest["marble"].split() == ["config1", "config2", "config3"] and pd.isna(longest["aerstop"])
    assert "Configuration #3 rocks longer on marble" in (palermo / "report.html").read_text(encoding="utf-8")


def test_validation_gives_the_medians_that_the_report_prints(palermo):
    told = {each["name"]: each["printed"] for each in numbers()}
    seconds = table(palermo, "runs").groupby(["block", "foundation"])["duration_s"].median()
    for (block, foundation), median in seconds.items():
        assert float(told[f"time_{block[-1]}_{foundation}"]) == pytest.approx(median, rel=5e-3)
    scene = "block == 'config1' and foundation == 'marble' and model == 'housner'"
    epsilon = table(palermo, "table3").query(scene)["epsilon_theta"].item()
    assert told["paper_slender"].endswith(" %")
    assert float(told["paper_slender"].rstrip(" %")) == pytest.approx(100 * epsilon, rel=5e-3)


def test_the_paper_may_take_the_wrong_law_where_impacts_scatter_and_freed_impacts_do_not(palermo):
    """ε_θ of one run is a coin toss between Winkler and Hunt–Crossley; Housner is farther than both."""
    paper = table(palermo, "paper").drop_duplicates(["test", "run", "model"])
    epsilon = paper.pivot(index=["test", "run"], columns="model", values="epsilon_theta")
    assert (epsilon[["hunt_crossley", "winkler"]].max(axis=1) < epsilon["housner"]).all()
    over_noise = table(palermo, "epsilon").pivot(
        index=["test", "run"], columns="model", values="residual_over_noise"
    )
    assert (over_noise["hunt_crossley"] < over_noise["winkler"]).all()


@pytest.mark.parametrize(
    "foundation, fitted, tolerance, impact_mean",
    [("marble", 0.957, 0.01, 0.94), ("aerstop", 0.905, 0.015, 0.845)],
)
def test_fitted_restitution_is_that_of_table_2_and_above_that_of_the_impacts(
    palermo, foundation, fitted, tolerance, impact_mean
):
    parameters = table(palermo, "paper").query(f"test == 'config2_{foundation}' and parameter == 'r'")
    assert len(parameters) == 3
    assert (parameters["value"] - fitted).abs().max() < tolerance
    impacts = table(palermo, "restitution").query(
        f"test == 'config2_{foundation}' and source == 'experiment' and impact <= 6"
    )
    assert impacts["r"].mean() == pytest.approx(impact_mean, abs=0.012)


def test_the_simulated_foundations_are_recovered(palermo):
    truth = json.loads((ROOT / "raw/palermo_virtual/truth.json").read_text(encoding="utf-8"))
    laws = table(palermo, "parameters").query("model == 'hunt_crossley' and parameter in ('k', 'lambda')")
    assert len(laws) == 36
    true = [truth[row.test]["runs"][int(row.run) - 1][row.parameter] for row in laws.itertuples()]
    z = (laws["value"] - true) / laws["u_total"]
    assert (z.abs() <= 1.96).mean() >= 0.95 and (z**2).mean() ** 0.5 <= 1.0
    error_percent = 100 * (laws["value"] / true - 1).abs()
    assert error_percent.median() <= 0.5
    of_k = error_percent[laws["parameter"] == "k"]
    assert of_k.median() <= 0.3 and of_k.max() <= 1.0


def test_the_scatter_of_impacts_is_recovered(palermo):
    """The records are made with 1 %, one draw of it for the impacts of each run."""
    epsilon = table(palermo, "epsilon").query("selected").drop_duplicates("test")
    assert set(epsilon["model"]) == {"hunt_crossley"} and epsilon["agrees_with_noise"].all()
    inside = (epsilon["sigma_r_low"] <= 0.01) & (epsilon["sigma_r_high"] >= 0.01)
    assert inside.sum() >= 5
    impacts = table(palermo, "restitution").query("source == 'experiment' and impact <= 5")
    assert 0.005 < impacts["delta"].std() < 0.02


def test_the_report_says_simulated_and_loads_nothing(palermo):
    page = (palermo / "report.html").read_text(encoding="utf-8")
    assert '<p class="simulated">' in page
    assert "default-src 'none'" in page
    assert (palermo / "report.html").stat().st_size < 6e6


def test_a_record_in_one_call_has_the_numbers_of_the_workflow_to_the_last_digit(palermo):
    block = freerock.Block(height_m=0.28, width_m=0.07, mass_kg=5.84)
    laser = freerock.Laser(beam="horizontal", position_m=0.20, range_m=0.1)
    record = freerock.load(ROOT / "raw/palermo_virtual/config2_marble.tdms", block, laser)
    results = freerock.open_results(palermo)
    dataset, fits = results.records["config2_marble"], results.fits["config2_marble"]
    np.testing.assert_array_equal(record.theta, dataset["theta"])
    for run in record.runs:
        group = f"run_{run.found.number}"
        np.testing.assert_array_equal(run.impacts.restitution, dataset[group]["restitution"])
        for law in ("housner", "winkler", "hunt_crossley"):
            fit, told = run.fit(law), fits[f"{group}/{law}"]
            np.testing.assert_array_equal(fit.value, told["value"])
            np.testing.assert_array_equal(fit.u_total, told["u_total"])


@pytest.mark.parametrize("name", ["open_fits", "open_record", "open_results", "parameters_in"])
def test_examples_that_read_products_print_what_they_say(palermo, monkeypatch, name):
    monkeypatch.chdir(palermo.parents[1])
    text = inspect.getdoc(getattr(freerock, name)).replace("# doctest: +SKIP", "# doctest: +ELLIPSIS")
    example = doctest.DocTestParser().get_doctest(text, {"freerock": freerock}, name, name, 0)
    assert example.examples and not doctest.DocTestRunner().run(example).failed


@pytest.mark.parametrize("page", ["datasets.md", "how-to/python.md"])
def test_pages_read_products(palermo, monkeypatch, page):
    monkeypatch.chdir(palermo.parents[1])
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    for program in re.findall(r"```python\n(.*?)```", text, re.S):
        exec(program, {"freerock": freerock, "xr": xr})


def test_each_group_of_a_fit_draws_and_selects_along_its_axes(palermo):
    with xr.open_datatree(palermo / "fits/config2_marble.nc") as fits:
        groups = {f"/run_3/{name}" for name in fits["run_3"].children}
    assert "/run_3/hunt_crossley" in groups
    for group in groups:
        fit = xr.load_dataset(palermo / "fits/config2_marble.nc", group=group)
        assert len(fit.data_vars) <= 20, group
        for each in fit.data_vars.values():
            if each.dims in (("time",), ("impact",)):
                at = fit[each.dims[0]]
                middle = each.interp({at.name: float(at[1] + at[2]) / 2})
                assert middle.item() == pytest.approx(each[1:3].mean(skipna=False).item(), nan_ok=True)
                assert each.sel({at.name: at[2]}).identical(each[2])
