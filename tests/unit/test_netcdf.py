"""netCDF in and out: what is written comes back, described, and always in the same bytes."""

import json
import re
import shutil
import subprocess
import sys
from dataclasses import fields, replace

import lmfit
import netCDF4
import numpy as np
import pytest
import xarray as xr
from fabricated import held

from freerock.errors import FreerockError
from freerock.files import sha256
from freerock.identification.fitted import Curve, Evidence, Fit, ImpactScatter
from freerock.identification.paper_fit import PaperFit
from freerock.identification.scatter import Scatter
from freerock.identification.u_total import Uncertainty
from freerock.models.given import legal
from freerock.models.laws import CANDIDATES, MODELS, PAPER_MODELS
from freerock.noise.spectrum import white_noise
from freerock.populations.impact_energy import ImpactEnergy
from freerock.products.estimates import parameters_in
from freerock.products.netcdf import (
    open_fits,
    open_record,
    write_failure,
    write_fits,
    write_record,
)
from freerock.products.netcdf_groups import IMPACT_VARIABLES, reasons_in
from freerock.products.runs import runs_in
from freerock.rotation.laboratory import Input
from freerock.runs.impacts import Impacts
from freerock.runs.runs import Measured, Run
from freerock.runs.u_of_measured import MeasuredTotal
from freerock.runs.verdict import Reason, Verdict, in_one_line
from freerock.selection.choice import Choice, Judged

ATTRS = {
    "campaign": "lab",
    "test": "a",
    "block": "tall",
    "foundation": "marble",
    "origin": "measured",
    "license": None,
    "start_time": "2017-05-02T09:00:00.000Z",
    "provenance": {"inputs": {"a.tdms": "00"}, "config": {"hum": True}},
}
SAMPLES = 400


def made_up_impacts(n=5):
    arrays = {field.name: np.linspace(0.1, 0.9, n) for field in fields(Impacts)}
    return Impacts(**arrays | {"theta_uplift": 0.01})


def made_up_total(n):
    return MeasuredTotal(2e-4, *(np.linspace(first, 0.1, n) for first in (0.01, 0.02, 0.03)))


def made_up_runs():
    run = Run(
        number=1,
        hold_start_s=0.1,
        release_s=0.2,
        release_stderr_s=0.001,
        fit_start_s=0.21,
        end_s=0.9,
        theta0=0.17,
        theta0_stderr=1e-5,
        sigma_theta=1e-4,
        n_impacts=7,
    )
    late = Reason("warn", "late", "late; and short"), Reason("ok", "overridden", "overridden: so")
    left_out = Reason("ok", "excluded", "excluded: so")
    return [run, replace(run, number=2, verdict=Verdict((*late, left_out)))]


def made_up_record():
    time = np.arange(SAMPLES) / 400
    theta = 0.17 * np.cos(7 * time)
    theta[3] = np.nan
    arrays = {
        "theta": theta,
        "sigma_theta": np.where(np.isnan(theta), np.nan, 1e-4),
        "flags": np.isnan(theta).astype(np.uint8),
        "voltage": 5 + theta,
    }
    variables = {name: ("time", values) for name, values in arrays.items()}
    return xr.Dataset(variables, {"time": time}, {"sampling_rate_hz": np.float64(400)})


INPUTS = (Input("b1", "width_m", 3e-4, False), Input("laser", "scale_fraction", 1e-3, True))


def made_up_energies():
    time_s = made_up_impacts().time_s
    each = np.linspace(0.8, 0.9, time_s.size)
    return ImpactEnergy(time_s, each, 0 * each + 2e-3)


def made_up_curve():
    time = np.arange(SAMPLES) / 400
    theta = np.cos(7 * time)
    return Curve(time, theta, 0.9 * theta)


def made_up_result(names):
    params = lmfit.Parameters()
    for i, name in enumerate(names):
        params.add(legal(name), value=1.0 + i, min=0.5, vary=name != "t0")
    return lmfit.minimizer.MinimizerResult(params=params, method="least_squares", nfev=80)


def made_up_fit(model, **changes):
    names = (*MODELS[model], *(["width"] if CANDIDATES[model].width else []), "theta0", "t0")
    n, delta = len(names), np.array([0.01, -0.02, 0.005])
    contributions = held(INPUTS, np.full((n, len(INPUTS)), 0.2))
    covariance = np.diag(np.full(n, 0.1**2 + 0.3**2 + 2 * 0.2**2))
    fit = {
        "model": model,
        "values": dict(zip(names, np.arange(1.0, n + 1).tolist(), strict=True)),
        "uncertainty": Uncertainty(covariance, np.full(n, 0.1), np.full(n, 0.3), contributions),
        "curve": made_up_curve(),
        "evidence": Evidence(0.01, True, 0.5, 1.01, 1.0, 2.0, -10.0, len(MODELS[model]), 80),
        "scatter": ImpactScatter(
            Scatter(0.012, 0.008, 0.02, 9.0), delta, 0 * delta + 1e-3, np.eye(3), np.zeros((n, 3))
        ),
        "success": True,
        "message": "converged",
        "result": made_up_result(names),
        "impacts": made_up_impacts(),
    }
    return Fit(**fit | changes)


def made_up_paper(law):
    names = (*MODELS[law], "theta0", "t0")
    values = dict.fromkeys(names, 2.0)
    result = made_up_result(names)
    return PaperFit(law, values, np.full(len(names), 0.1), 0.02, made_up_curve(), True, "converged", result)


CHOICE = Choice(
    "winkler",
    "repeatability",
    "prediction",
    "because",
    (Judged("housner", "rejected", "no", 900.0, 1, 40.0), Judged("winkler", "selected", "yes", 10.0, 2, 1.2)),
)


def write(folder, name="a"):
    runs = made_up_runs()
    impacts = [made_up_impacts(), made_up_impacts(0)]
    totals = [made_up_total(len(each.time_s)) for each in impacts]
    noise = white_noise(1e-4, 400.0)
    found = Measured(runs, impacts, noise)
    write_record(folder / f"record_{name}.nc", made_up_record(), found, totals, ATTRS)
    fits = {number: {model: made_up_fit(model) for model in MODELS} for number in (1, 2)}
    write_fits(
        folder / f"fits_{name}.nc",
        fits,
        ATTRS | {"verdict": "ok", "reasons": []},
        CHOICE,
        {number: {law: made_up_paper(law) for law in PAPER_MODELS} for number in (1, 2)},
        energies={number: {"winkler": made_up_energies()} for number in fits},
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("datasets")
    write(folder)
    return folder


def assert_equal(found, expected):
    for field in fields(expected):
        np.testing.assert_array_equal(getattr(found, field.name), getattr(expected, field.name))


def test_record_comes_back(folder):
    tree, record = open_record(folder / "record_a.nc"), made_up_record()
    for name in ("time", "theta", "flags"):
        np.testing.assert_array_equal(tree[name].values, record[name].values, strict=True)
    for name in ("sigma_theta", "voltage"):
        np.testing.assert_array_equal(tree[name].values, record[name].values.astype(np.float32), strict=True)
    assert tree.attrs["sampling_rate_hz"] == 400
    assert (tree.attrs["campaign"], tree.attrs["origin"]) == ("lab", "measured")


def test_runs_and_impacts_come_back(folder):
    tree = open_record(folder / "record_a.nc")
    assert list(tree.children) == ["run_1", "run_2"]
    assert runs_in(tree) == made_up_runs()
    assert [tree[name].attrs["verdict"] for name in tree.children] == ["ok", "warn"]
    for run, written in (("run_1", made_up_impacts()), ("run_2", made_up_impacts(0))):
        for field, name in (*IMPACT_VARIABLES.items(), ("theta_uplift", "theta_uplift")):
            np.testing.assert_equal(tree[run].dataset[name].values, getattr(written, field))


def test_fits_come_back(folder):
    tree = open_fits(folder / "fits_a.nc")
    assert list(tree.children) == ["run_1", "run_2"]
    papers = [f"paper_{law}" for law in PAPER_MODELS]
    for group in ("run_1", "run_2"):
        assert {*tree[group].children} == {*MODELS, *papers, "choice"}
        for model in MODELS:
            node, fit = tree[f"{group}/{model}"], made_up_fit(model)
            assert tuple(node["parameter"].values) == fit.parameters
            assert tuple(node["unit"].values) == fit.units
            for name, expected in (
                ("value", fit.value),
                ("stderr", fit.uncertainty.stderr),
                ("u_law", fit.uncertainty.u_law),
                ("u_total", fit.u_total),
                ("covariance", fit.uncertainty.covariance),
                ("theta_model", np.float32(fit.curve.theta_model)),
                ("residual", np.float32(fit.curve.residual)),
                ("delta", [0.01, -0.02, 0.005, np.nan, np.nan]),
                ("impact_time", made_up_impacts().time_s),
            ):
                np.testing.assert_array_equal(node[name].values, expected)
            assert (node["epsilon_theta"].item(), node["sigma_r"].item()) == (0.01, 0.012)
            assert node.attrs["agrees_with_noise"] == node.attrs["success"] == 1
            assert (node.attrs["sigma_r_low"], node.attrs["residual_over_noise"]) == (0.008, 1.01)
            assert (node.attrs["message"], node.attrs["nfev"]) == ("converged", 80)
            assert node.attrs["model"] == model
        np.testing.assert_array_equal(tree[group]["theta"].values, made_up_curve().theta)
    energies, node = made_up_energies(), tree["run_1/winkler"]
    np.testing.assert_array_equal(node["restitution_energy"].values, energies.restitution)
    np.testing.assert_array_equal(node["restitution_energy_u"].values, energies.u_total)
    assert "restitution_energy" not in tree["run_1/housner"]
    paper = tree["run_2/paper_winkler"]
    assert paper["value"].sel(parameter="c").item() == 2.0 and paper["epsilon_theta"].item() == 0.02
    choice = tree["run_1/choice"]
    assert (choice.attrs["selected"], choice.attrs["level"]) == ("winkler", "repeatability")
    assert choice["residual_over_noise"].sel(candidate="housner").item() == 40.0


def test_parameters_come_back_as_lmfit_has_them(folder):
    fit = open_fits(folder / "fits_a.nc")["run_1/winkler"].to_dataset()
    found = parameters_in(fit)
    assert [*found] == ["k", "c", "theta0", "t0"]
    assert (found["c"].value, found["c"].min, found["c"].vary, found["t0"].vary) == (2.0, 0.5, True, False)
    assert found["k"].stderr == pytest.approx(fit["u_total"].values[0]) and found["t0"].stderr is None


def test_plain_xarray_selects_by_time_and_impact_in_every_group(folder):
    """What a user of xarray alone does: `.sel`, `.interp` and `.plot` along coordinates."""
    record = xr.load_dataset(folder / "record_a.nc")
    np.testing.assert_allclose(record["theta"].interp(time=0.5), 0.17 * np.cos(3.5), rtol=1e-3)
    assert record["theta"].sel(time=slice(0.2, 0.9)).sizes["time"] == 281
    np.testing.assert_allclose(record["noise_density"], 2 * 1e-8 / 400)
    told, noise = json.loads(record.attrs["noise"]), white_noise(1e-4, 400.0)
    assert told == {name: np.array(each).tolist() for name, each in vars(noise).items()}  # to the last digit
    assert record["frequency"][0] > 0 and record["frequency"][-1] < 200
    run = xr.load_dataset(folder / "record_a.nc", group="run_1")
    assert run["restitution"].sel(impact=2).item() == made_up_impacts().restitution[1]
    fit = xr.load_dataset(folder / "fits_a.nc", group="run_1/winkler")
    assert fit["residual"].sel(time=0.5, method="nearest").item() == np.float32(-0.1 * np.cos(3.5))
    assert fit["value"].sel(parameter="c").item() == 2.0 and len(fit.data_vars) <= 20
    inputs = xr.load_dataset(folder / "fits_a.nc", group="run_1/winkler/inputs")
    assert inputs["contribution"].sel(parameter="k", input="width_m").item() == 0.2
    with xr.open_datatree(folder / "fits_a.nc") as tree:
        assert tree["run_2/hunt_crossley/theta_model"].dims == ("time",)
        assert tree["run_2/hunt_crossley/impact_time"].sel(impact=5).item() == 0.9


def test_failed_record_is_a_product(tmp_path):
    error = FreerockError("raw/a.tdms", "is truncated", "record it again")
    reason = Reason("fail", "not_processed", str(error))
    write_failure(tmp_path / "a.nc", reason, ATTRS)
    tree = open_record(tmp_path / "a.nc")
    assert (tree.attrs["verdict"], reasons_in(tree.attrs)) == ("fail", (reason,))
    assert in_one_line([reason]) == "raw/a.tdms: is truncated; record it again"
    assert (tree.attrs["campaign"], tree.attrs["test"]) == ("lab", "a")
    assert runs_in(tree) == []
    write_fits(tmp_path / "b.nc", {}, ATTRS | {"verdict": "fail", "reasons": [reason]})
    assert not open_fits(tmp_path / "b.nc").children


def test_attributes_follow_cf_and_acdd(folder):
    with netCDF4.Dataset(folder / "record_a.nc") as file:
        assert file.Conventions == "CF-1.11, ACDD-1.3"
        assert file.title == "lab: a"
        assert file.time_coverage_start == ATTRS["start_time"]
        assert "license" not in file.ncattrs()
        assert json.loads(file.provenance) == {"inputs": {"a.tdms": "00"}, "config": {"hum": True}}
        assert file["time"].units == f"seconds Since {ATTRS['start_time']}"
        assert file["time"].standard_name == "time"
        assert file["time"].long_name == "time from the start of the record"
        assert "_FillValue" not in file["time"].ncattrs()
        assert file["theta"].ancillary_variables == "sigma_theta flags"
        assert file["flags"].flag_meanings == "error_level out_of_range saturated target_lost dropout spike"
        assert file["flags"].flag_masks.dtype == file["flags"].dtype == np.uint8
        assert file["theta"].filters()["complevel"] == 1
        assert file["run_2"].excluded == 1
        assert file["run_1/restitution"].ancillary_variables == "restitution_stderr restitution_u"
        assert "time" not in file["run_1"].variables


def test_same_inputs_same_bytes(folder, tmp_path):
    write(tmp_path, "b")
    for product in ("record", "fits"):
        assert sha256(folder / f"{product}_a.nc") == sha256(tmp_path / f"{product}_b.nc")


def test_unreadable_datasets_are_told_in_one_line(folder, tmp_path):
    path = tmp_path / "a.nc"
    with pytest.raises(FreerockError, match=r"a\.nc: there is no such file; run snakemake to make it"):
        open_record(path)
    whole = (folder / "record_a.nc").read_bytes()
    for content in (b"", b"time,theta\n", whole[: len(whole) // 2]):
        path.write_bytes(content)
        with pytest.raises(
            FreerockError, match=r"a\.nc: is not a readable netCDF file \(.*\); delete the file"
        ):
            open_record(path)
    xr.Dataset({"theta": 1.0}).to_netcdf(path)
    with pytest.raises(FreerockError, match=r"a\.nc: is not the record dataset of a record; delete the file"):
        open_record(path)
    with pytest.raises(FreerockError, match="is not the fits dataset of a record"):
        open_fits(folder / "record_a.nc")


# As MATLAB reads it: ncread and ncreadatt of the netCDF library, h5read of HDF5.
PLAIN_NETCDF = """
import sys
sys.modules["freerock"] = None
import h5py, netCDF4

with netCDF4.Dataset("record_a.nc") as file:
    print(file["time"].dtype, file["time"][-1], file["theta"][200], file["run_1"]["impact_time"][0])
with netCDF4.Dataset("fits_a.nc") as file:
    print(file["run_1/winkler/value"][0], file["run_1/winkler/parameter"][0])
with h5py.File("record_a.nc") as file:
    print(file["time"].dtype, file["time"][-1], file["theta"][200], file["run_1/impact_time"][0])
    print(file["time"].attrs["units"].decode(), file.attrs["origin"].decode())
with h5py.File("fits_a.nc") as file:
    print(file["run_1/winkler/value"][0], file["run_1/winkler/parameter"].asstr()[0])
"""


def printed_by(program, folder):
    """The words a program of a reader prints, numbers as such."""
    done = subprocess.run([sys.executable, "-c", program], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    words = done.stdout.split()
    return [float(word) if re.fullmatch(r"-?[\d.]+(e-?\d+)?", word) else word for word in words]


def test_readers_of_netcdf_and_hdf5_open_the_products(folder):
    last, theta = (SAMPLES - 1) / 400, pytest.approx(0.17 * np.cos(3.5))
    record = ["float64", last, theta, 0.1]
    fit = [1.0, "k"]
    since = f"seconds Since {ATTRS['start_time']}".split()
    assert printed_by(PLAIN_NETCDF, folder) == [*record, *fit, *record, *since, "measured", *fit]


def test_xarray_reads_times_in_seconds_though_cf_has_a_date(folder):
    record = xr.load_dataset(folder / "record_a.nc")
    assert record["time"].dtype == float and record["theta"].sel(time=0.5).dtype == float
    fit = xr.load_dataset(folder / "fits_a.nc", group="run_1/winkler")
    assert fit["time"].attrs == {"long_name": "time since the release", "units": "s"}
    with netCDF4.Dataset(folder / "fits_a.nc") as file:
        assert json.loads(file.long_names)["u_law"].startswith("standard uncertainty of the parameter")


@pytest.mark.skipif(not shutil.which("ncdump"), reason="no ncdump here: apt-get install netcdf-bin")
@pytest.mark.parametrize("product", ["record", "fits"])
def test_ncdump_shows_the_head_of_a_product(folder, product):
    done = subprocess.run(["ncdump", "-h", folder / f"{product}_a.nc"], capture_output=True, text=True)
    assert done.returncode == 0
    assert "group: run_2" in done.stdout
    if product == "fits":
        law = (
            done.stdout.partition("  group: winkler {")[2]
            .partition("\n  group: ")[0]
            .partition("group: inputs")[0]
        )
        assert 20 < law.count("\n") <= 54  # a screen
