"""The shipped campaign, from record files to report."""

import math
import re
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
import xarray as xr
from found_again import found_again
from golden_numbers import differences

from freerock.models.block import Block
from freerock.models.simulate import simulate
from freerock.report.beside_published import beside_published
from freerock.report.findings import TABLES, findings
from freerock.report.numbers import plain
from freerock.tables.csvfile import read_csv

LABELS = {f"config{n}": f"Configuration #{n}" for n in (1, 2, 3)} | {
    "marble": "Marble",
    "aerstop": "Aerstop CN20",
}
LONGEST = {"config1": "marble", "config2": "marble", "config3": "aerstop"}

CONTRACT = {
    "runs": "campaign test run block foundation origin theta0_deg theta0_u_deg release_s duration_s "
    "n_impacts n_restitution sigma_theta_deg verdict reasons excluded",
    "parameters": "campaign test run block foundation model parameter value stderr ci95_low ci95_high "
    "discrepancy u_total unit success given in_phase",
    "epsilon": "campaign test run block foundation model epsilon_theta final_time_s epsilon_holdout "
    "n_parameters aic bic selected success epsilon_in_phase",
    "choice": "campaign test run block foundation model status explains n_freed epsilon_theta "
    "epsilon_holdout epsilon_holdout_runs bic noise_p noise_ratio noise_low_hz noise_high_hz added_damping "
    "reason",
    "candidates": "campaign block foundation model n_freed n_runs n_selected n_also_possible n_rejected "
    "n_not_fitted n_explains epsilon_theta epsilon_holdout r k_n_m2 c_n_s_m2 lambda_n_s_m3 contact_width_m "
    "kappa_n_m3",
    "restitution": "campaign test run source impact time_s r r_stderr r_u block foundation peak_before_deg "
    "peak_before_u_deg r_energy r_energy_stderr r_energy_u impact_speed_m_s "
    "r_block r_block_u peak_before_block_deg",
    "reasons": "campaign test run block foundation verdict reason value limit unit key sentence",
    "pulls": "campaign test run block foundation model input input_owner input_u input_unit input_stated "
    "input_moved input_remaining input_pull impact_r_percent impact_k_percent impact_c_percent "
    "impact_lambda_percent impact_kappa_percent",
    "parts": "campaign test run block foundation model parameter unit part start_s end_s value stderr",
    "restitution_law": "campaign block foundation quantity n_runs n_impacts speed_low_m_s speed_high_m_s "
    "speed_m_s r r_stderr slope_s_m slope_stderr slope_low slope_high trend",
}


DOCS = Path(__file__).parents[2] / "docs"
NUMBER = r"(\d+(?:\.\d+)?)"
INPUTS = {"width": "width_m", "beam": "position_m", "height": "height_m", "scale": "scale_fraction"}
INPUTS |= {"centre of mass": "com_height_m", "inertia": "inertia_kg_m2", "runs": "runs"}


def text_of(page):
    return (DOCS / page).read_text(encoding="utf-8")


def rows_of_records(first):
    """Cells of the rows of docs/uncertainty.md below a heading, by record."""
    below = text_of("uncertainty.md").partition(first)[2].partition("\n\n")[0]
    rows = re.findall(r"^\| configuration (\d), (\w+) \| (.*) \|$", below, re.M)
    assert len(rows) == 4
    return {f"config{n}_{bed.lower()}": cells.split(" | ") for n, bed, cells in rows}


def agrees(stated, value):
    """Whether a number as printed is a value, rounded."""
    (printed,) = re.findall(NUMBER, stated)
    digits = len(printed.partition(".")[2])
    return abs(float(printed) - value) <= 0.5001 * 10**-digits


def budget_of_k(palermo):
    budget = table(palermo, "budget").query("level == 'record' and model == 'hunt_crossley'")
    return budget.query("parameter == 'k'")


def table(palermo, name):
    return pd.read_csv(palermo / f"tables/{name}.csv", dtype={"run": str})


@pytest.mark.parametrize("name", CONTRACT)
def test_tables_have_the_columns_other_peoples_scripts_rely_on(palermo, name):
    assert list(table(palermo, name).columns) == CONTRACT[name].split()


def test_each_number_is_as_kept(palermo):
    assert differences(palermo, "palermo") == []


def test_every_run_of_every_record_is_found_and_called_simulated(palermo):
    runs = table(palermo, "runs")
    assert (runs.groupby("test")["run"].agg("".join) == "123").all()
    assert runs["test"].nunique() == 6
    assert set(runs["origin"]) == {"simulated"}
    assert set(runs["verdict"]) == {"ok"}


def test_hunt_crossley_is_nearer_than_winkler_and_winkler_than_housner_on_every_scene(palermo):
    epsilon = table(palermo, "epsilon").pivot(index=["test", "run"], columns="model", values="epsilon_theta")
    assert (epsilon["hunt_crossley"] < epsilon["winkler"]).all()
    assert (epsilon["winkler"] < epsilon["housner"]).all()


@pytest.mark.parametrize(
    "foundation, fitted, tolerance, impact_low, impact_high",
    [("marble", 0.957, 0.006, 0.93, 0.95), ("aerstop", 0.905, 0.010, 0.82, 0.87)],
)
def test_fitted_restitution_is_that_of_table_2_and_above_that_of_the_impacts(
    palermo, foundation, fitted, tolerance, impact_low, impact_high
):
    parameters = table(palermo, "parameters").query(f"test == 'config2_{foundation}' and parameter == 'r'")
    assert len(parameters) == 3
    assert (parameters["value"] - fitted).abs().max() < tolerance
    impacts = table(palermo, "restitution").query(
        f"test == 'config2_{foundation}' and source == 'experiment' and impact <= 6"
    )
    assert impacts["r"].between(impact_low, impact_high).all()


def test_the_simulated_foundations_are_recovered(palermo):
    recovered = table(palermo, "recovered")
    assert len(recovered) == 36
    of = ["test", "run", "parameter"]
    laws = table(palermo, "parameters").query("model == 'hunt_crossley'")
    both = recovered.merge(laws, on=of, suffixes=("", "_fit"))
    assert len(both) == 36
    z = (both["value"] - both["truth"]) / both["u_total"]
    assert (z.abs() <= 1.96).mean() >= 0.95 and (z**2).mean() ** 0.5 <= 1.0
    assert recovered["error_percent"].abs().median() <= 0.2
    assert recovered["error_percent"].abs().max() <= 1.5


def test_the_report_says_simulated_and_loads_nothing(palermo):
    page = (palermo / "report.html").read_text(encoding="utf-8")
    assert '<p class="simulated">' in page
    assert "default-src 'none'" in page
    assert (palermo / "report.html").stat().st_size < 6e6


def test_the_docs_state_the_measured_uncertainties_of_the_products(palermo):
    runs, impacts = table(palermo, "runs"), table(palermo, "restitution").query("source == 'experiment'")
    for test, cells in rows_of_records("| | θ₀ | stderr |").items():
        (run,) = runs.query(f"test == '{test}' and run == '1'").to_dict("records")
        (one,) = impacts.query(f"test == '{test}' and run == '1' and impact == 1").to_dict("records")
        with xr.open_dataset(palermo / f"records/{test}.nc", group="run_1") as dataset:
            stderr = math.degrees(float(dataset["theta0_stderr"]))
        values = run["theta0_deg"], stderr, run["theta0_u_deg"], one["r"], one["r_stderr"], one["r_u"]
        assert all(map(agrees, cells, values)), test
    every = impacts.query("run == '1'").dropna(subset=["r_u"])
    loud = every["r_stderr"] ** 2 > every["r_u"] ** 2 / 2
    assert every[~loud]["impact"].max() == 7  # "from the eighth impact on, noise dominates"


def test_the_docs_state_the_budget_of_the_products(palermo):
    budget = budget_of_k(palermo)
    means = table(palermo, "populations").query("model == 'hunt_crossley' and parameter == 'k'")
    for test, (k, stderr, total, shares) in rows_of_records("| | k [N/m²] |").items():
        (mean,) = means.query(f"test == '{test}'").to_dict("records")
        assert agrees(k.partition("·")[0], mean["mean"] / 1e6)
        assert agrees(stderr, 100 * mean["stderr"] / mean["mean"])
        assert agrees(total, 100 * mean["u_total"] / mean["mean"])
        found = budget.query(f"test == '{test}'").set_index("input")["share_percent"]
        printed = re.findall(rf"([a-z]+) {NUMBER} %", shares)
        assert [INPUTS[name] for name, _ in printed] == list(found.nlargest(len(printed)).index)
        assert all(agrees(percent, found[INPUTS[name]]) for name, percent in printed)
    largest = budget.loc[budget.groupby("test")["share_percent"].idxmax()]
    assert (largest["input"] == "runs").all() and (largest["share_percent"] > 50).sum() == 5


def test_the_docs_state_the_correlation_of_k_and_damping(palermo):
    fits = {}
    for path in sorted((palermo / "fits").glob("*.nc")):
        with xr.open_dataset(path, group="run_1/hunt_crossley") as fit:
            of = {"parameter": "k"}, {"parameter": "lambda"}
            errors = [100 * float(fit["stderr"].sel(each) / fit["value"].sel(each)) for each in of]
            fits[path.stem] = [float(fit["correlation"].sel(parameter="k", parameter_b="lambda")), *errors]
    correlation, of_k, of_damping = zip(*fits.values(), strict=True)
    stated = re.search(
        rf"it is {NUMBER} to {NUMBER}\. .* at most {NUMBER} % of k and {NUMBER} % of λ",
        text_of("identification.md"),
        re.S,
    )
    assert stated and len(fits) == 6
    values = min(correlation), max(correlation), max(of_k), max(of_damping)
    assert all(map(agrees, stated.groups(), values))
    order = sorted(fits, key=lambda test: fits[test][0])
    assert order[0] == "config3_marble" and order[-1] == "config1_marble"


def test_first_impact_of_the_compliant_base_is_later_than_the_rigid_one():
    """What the fitted r makes up for: 0.308 s against 0.269 s on marble, configuration 2."""
    block, time = Block(0.28, 0.07, 5.84), [0.0, 0.5]
    compliant, rigid = (
        simulate(model, block, parameters, time, theta0=math.radians(10)).impacts[0]
        for model, parameters in (
            ("hunt_crossley", {"k": 6.88e6, "lambda": 1.3e8}),
            ("housner", {"r": 0.958}),
        )
    )
    assert compliant == pytest.approx(0.308, abs=5e-4)
    assert rigid == pytest.approx(0.26888, abs=5e-6)


def test_every_number_of_the_findings_is_found_again_in_the_tables(palermo):
    found = findings({name: read_csv(palermo / f"tables/{name}.csv") for name in TABLES}, LABELS)
    assert found_again(found, palermo / "tables", LABELS) > 20
    page = (palermo / "report.html").read_text(encoding="utf-8")
    first = page.partition('<section id="findings"')[2].partition("</section>")[0]
    numbers = [
        part for each in found for told in each.sentences for part in told if not isinstance(part, str)
    ]
    assert all(f">{part.text}</span>" in first for part in numbers)


def test_configuration_3_rocks_longest_on_marble_and_the_report_says_why(palermo):
    names = ("runs", "foundations", "restitution_comparison", "table2", "table3")
    beside = beside_published(
        {name: read_csv(palermo / f"tables/{name}.csv") for name in names}, LONGEST, LABELS
    )
    (told,) = [plain(each) for each in beside.differs if "rocks longest" in plain(each)]
    assert told.startswith("Configuration #3 rocks longest on Marble (")
    assert "in the publication on Aerstop CN20. Here its first impact keeps r = " in told
    assert "Configuration #1 and Configuration #2 rock longest on Marble, as published." in map(
        plain, beside.agrees
    )


WITHOUT_FREEROCK = """
import sys
sys.modules["freerock"] = None
import h5py
import netCDF4
import numpy as np
import xarray as xr

path = sys.argv[1]
maps = {name: node.to_dataset() for name, node in xr.open_datatree(path).children.items()}
assert maps
for name, seen in maps.items():
    assert seen["epsilon_theta"].dims == ("lambda", "k") and float(seen["epsilon_theta"].min()) > 0
    with netCDF4.Dataset(path) as file, h5py.File(path) as as_matlab:
        for values in (file[name]["epsilon_theta"][:], as_matlab[name]["epsilon_theta"][()]):
            np.testing.assert_array_equal(values, seen["epsilon_theta"].values)
        assert file[name]["k"].units == "N m-2"
"""


def test_misfit_maps_are_read_without_this_package(finished):
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_FREEROCK, str(finished / "results/small/misfit_map.nc")],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
