"""The review desk without a browser: what it tries is what the jobs write; what it keeps; who it answers."""

import csv
import shutil

import numpy as np
import pytest
import xarray as xr
from small_campaign import BLOCKS, CAMPAIGN, COLUMNS, MAT

from freerock.config.review_log import log_of, read_changes
from freerock.errors import FreerockError
from freerock.jobs.log import make_or_give_up
from freerock.jobs.make_fits import give_up_fits, make_fits
from freerock.jobs.make_record import make_record
from freerock.models.laws import MODELS
from freerock.products.contents import fits_of
from freerock.products.netcdf import open_fits, open_record
from freerock.review.corrections import Correction, corrected, corrected_cells
from freerock.review.desk import Desk
from freerock.review.signals import signals_of
from freerock.rotation.rotation import rotation_of
from freerock.tables.number_text import quantity
from freerock.tables.populations import means_in, populations_table
from freerock.tables.tidy_tables import contributions_table, parameters_table, restitution_table, runs_table
from freerock.virtual_lab.virtual_record import Recording, VirtualRelease, simulate_record
from freerock.virtual_lab.write_tdms import write_records

FITS = "fits: {models: [winkler, hunt_crossley], kinematics: [guided]}\n"
LINES = "tall,tall.tdms,,tall,mat,high,,,,\nlost,lost.tdms,,squat,mat,low,,,,\n"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A campaign that was never analysed: a record of two runs, and one whose file is missing."""
    folder = tmp_path_factory.mktemp("lab")
    shape, laser, angle = BLOCKS["tall"]
    releases = [VirtualRelease(angle, MAT, tilt_s=1.2, held_s=1.5, pause_s=1.5)] * 2
    recording = Recording(rate_hz=500.0)
    record = simulate_record(shape, laser, "hunt_crossley", releases, seed=2, recording=recording)
    (folder / "config/campaigns").mkdir(parents=True)
    (folder / "config/campaigns/small.yaml").write_text(CAMPAIGN + FITS)
    (folder / "config/campaigns/small.csv").write_text(COLUMNS + LINES)
    write_records(folder / "raw/small", [("tall", record)])
    return folder


@pytest.fixture
def lab(made, tmp_path, monkeypatch):
    shutil.copytree(made, tmp_path / "lab")
    monkeypatch.chdir(tmp_path / "lab")
    return tmp_path / "lab"


@pytest.fixture
def desk(lab):
    return Desk("small")


BLANK = {"overrides": [], "exclude": [], "stretches": [], "reason": "", "note": ""}


def correction(**own):
    return Correction.model_validate(BLANK | own)


def moved(run, release_s, end_s):
    return [{"run": run, "release_s": release_s, "end_s": end_s, "hold_s": None}]


def cell(lab, column, test="tall"):
    with open(lab / "config/campaigns/small.csv", newline="", encoding="utf-8") as file:
        return next(row[column] for row in csv.DictReader(file) if row["test"] == test)


def parameters(picture, of="fits"):
    return {
        (each["model"], one["name"]): (one["value"], one["u"])
        for each in picture[of]["candidates"]
        for one in each["parameters"]
    }


def numbers_in(path, group):
    tree = open_fits(path).children[group]
    return {
        (model, str(name)): (f"{value:.10g}", f"{u:.10g}" if np.isfinite(u) else "")
        for model, fit in tree.children.items()
        if model in MODELS
        for name, value, u in zip(
            fit["parameter"].values, fit["value"].values, fit["u_total"].values, strict=True
        )
    }


@pytest.fixture
def job(desk, tmp_path):
    """The fit job of the record: its product under other settings."""
    line = desk.campaign.record("tall")
    of_record, of_fits = desk._bench.settings(desk.campaign, line)
    make_record(of_record, tmp_path / "r.nc")
    product = tmp_path / "f.nc"

    def run(**settings):
        told = of_fits | settings
        make_or_give_up(
            lambda: make_fits(told, tmp_path / "r.nc", product),
            lambda reason: give_up_fits(told, product, reason),
        )
        return open_fits(product)

    return run


@pytest.mark.slow
def test_what_is_given_of_parameters_reaches_the_product_and_table_2(job, caplog):
    given = {"winkler": {"c": {"expr": "3e-3*k"}}, "hunt_crossley": {"k": {"value": MAT["k"], "vary": False}}}
    with caplog.at_level("INFO", "freerock"):
        tree = job(options={"parameters": given})
    fits = {(run, model): fit for run, model, fit, _ in fits_of(tree)}
    for run in (1, 2):
        tied, fixed = fits[run, "winkler"], fits[run, "hunt_crossley"]
        assert tied["vary"].values.tolist() == [1, 0, 1, 1] and tied["expr"].values[1] == "3e-3*k"
        np.testing.assert_allclose(tied["value"].values[1], 3e-3 * tied["value"].values[0])
        assert fixed["value"].values[0] == MAT["k"] and fixed["vary"].values.tolist() == [0, 1, 1, 1]
    parameters = parameters_table([tree])
    given = {(row.model, row.parameter): row.given for row in parameters.itertuples()}
    assert given["winkler", "c"] == "tied: 3e-3*k" and given["hunt_crossley", "k"] == "fixed"
    assert "[[Variables]]" in caplog.text and "(fixed)" in caplog.text


@pytest.mark.slow
def test_a_correction_gives_what_the_jobs_write(desk, tmp_path):
    seen = desk.record("tall", 1)["picture"]
    own = correction(overrides=moved(1, seen["release"] + 0.02, seen["end"]), reason="late")
    tried = desk.refit("tall", own, 1, seen["release"], whole=False)
    whole = desk.refit("tall", own, 1, seen["release"], whole=True)
    line = desk.campaign.record("tall")
    of_record, of_fits = desk._bench.settings(desk.campaign, corrected(line, corrected_cells(own, line)))
    make_record(of_record, tmp_path / "r.nc")
    make_fits(of_fits, tmp_path / "r.nc", tmp_path / "f.nc")
    alone, together = parameters(tried["picture"]), numbers_in(tmp_path / "f.nc", "run_1")
    for name in (("hunt_crossley", "k"), ("winkler", "k")):  # of one run, without the scatter of the others
        (value, u), (expected, _) = alone[name], together[name]
        assert float(value) == pytest.approx(float(expected), abs=3 * float(u))
    assert parameters(whole["picture"]) == numbers_in(tmp_path / "f.nc", "run_1")
    (row,) = runs_table([open_record(tmp_path / "r.nc")])[:1].itertuples()
    assert row.theta0_u_deg > 0
    for each in (tried, whole):
        theta0 = quantity(row.theta0_deg, row.theta0_u_deg)  # as report and quality page print it
        assert each["picture"]["facts"][0] == ["α", f"{theta0}°"]
    fits = [open_fits(tmp_path / "f.nc")]
    means = populations_table(means_in(parameters_table(fits), contributions_table(fits)))
    assert parameters(whole["picture"], "means") == {
        (row.model, row.parameter): (
            f"{row.mean:.10g}",
            f"{row.u_total:.10g}" if np.isfinite(row.u_total) else "",
        )
        for row in means[means["level"] == "record"].itertuples()
    }
    assert whole["cells"] == {"override": corrected_cells(own, line)["override"], "reason": "late"}


@pytest.mark.slow
def test_an_excluded_run_leaves_the_mean(desk):
    before = desk.refit("tall", correction(), 1, None, whole=True)
    after = desk.refit("tall", correction(exclude=[2], reason="knocked"), 1, None, whole=True)
    assert [row["excluded"] for row in after["rows"]] == [False, True]
    assert parameters(after["picture"]).keys() == parameters(before["picture"]).keys()
    assert parameters(after["picture"], "means") != parameters(before["picture"], "means")


@pytest.mark.slow
def test_what_stands_in_a_stretch_left_out_reaches_no_number(desk, lab, tmp_path):
    """The jobs' fits of a laser that was hit within the stretch are the desk's of one that was not."""
    run = desk.record("tall", 1)["picture"]
    at = run["impacts"]["measured"][3][0]
    own = correction(stretches=[[at - 0.05, at + 0.03]], reason="hit")
    line = desk.campaign.record("tall")
    tried = desk.refit("tall", own, 1, run["release"], whole=True)
    assert [each["text"].endswith("left out: hit") for each in tried["picture"]["reasons"]] == [True]
    assert [row["verdict"] for row in tried["rows"]] == ["ok", "ok"]
    of_record, of_fits = desk._bench.settings(desk.campaign, corrected(line, corrected_cells(own, line)))
    rotation = rotation_of(of_record)
    hit = rotation.assign(theta=rotation["theta"] + 0.1 * (abs(rotation["time"] - at) < 0.025))
    make_record(of_record, tmp_path / "hit.nc", lambda _: hit)
    make_fits(of_fits, tmp_path / "hit.nc", tmp_path / "hit_fits.nc")
    assert parameters(tried["picture"]) == numbers_in(tmp_path / "hit_fits.nc", "run_1")
    r = open_record(tmp_path / "hit.nc")["run_1"]["restitution"].values
    assert np.isnan(r).tolist() == [False, False, True, True]
    table = restitution_table([open_record(tmp_path / "hit.nc")], [])
    assert table["r"].isna().tolist() == np.isnan(r).tolist() + [False] * (len(table) - len(r))
    flags = open_record(tmp_path / "hit.nc")["flags"]
    hidden = np.flatnonzero(flags.values & 64)
    assert flags.attrs["flag_meanings"].split()[-1] == "left_out" and hidden.size == pytest.approx(40, abs=2)


def test_only_cells_that_differ_are_kept_and_undo_brings_the_file_back(desk, lab):
    path = lab / "config/campaigns/small.csv"
    before = path.read_bytes()
    own = correction(exclude=[2], reason="knocked, seen")
    shown = desk.keep({"tall": own}, desk.listing()["digest"], "")
    assert path.read_bytes() == before.replace(b"high,,,,", b'high,2,,"knocked, seen",')
    assert shown["undo"] == 1
    changes = read_changes(log_of(path))
    assert [(each.cell, each.before, each.after, each.why) for each in changes] == [
        ("exclude", "", "2", "knocked, seen"),
        ("reason", "", "knocked, seen", "knocked, seen"),
    ]
    desk.undo()
    assert path.read_bytes() == before
    assert [each.why for each in read_changes(log_of(path))][2:] == ["undone", "undone"]
    with pytest.raises(FreerockError, match="nothing was saved since the desk was opened"):
        desk.undo()


REFUSED = {
    "a note without why": (correction(note="x"), "tall: note: is changed without a reason; say why"),
    "an exclusion without a reason": (
        correction(exclude=[1]),
        "tall: reason: exclude or override is given without a reason; say why",
    ),
    "a stretch that ends before it begins": (
        correction(stretches=[[5.0, 4.0]], reason="x"),
        "tall: exclude: the stretch 5.000:4.000 ends before it begins; give its begin first",
    ),
    "an end before its release": (
        correction(overrides=moved(1, 5.0, 4.0), reason="x"),
        "tall: override: run 1 ends before it is released; give the release first",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused(name, desk, lab):
    own, told = REFUSED[name]
    before = (lab / "config/campaigns/small.csv").read_bytes()
    with pytest.raises(FreerockError) as error:
        desk.keep({"tall": own}, desk.listing()["digest"], "")
    assert str(error.value) == told
    assert (lab / "config/campaigns/small.csv").read_bytes() == before
    assert not log_of(lab / "config/campaigns/small.csv").exists()


def test_a_failed_record_and_one_left_out_are_seen(desk, lab):
    assert "lost.tdms" in desk.record("lost", None)["failure"]
    desk.keep({"tall": correction(exclude="record", reason="wet")}, desk.listing()["digest"], "")
    left_out = desk.record("tall", None)
    assert left_out["failure"] == "excluded: wet"
    assert len(desk.window("tall", *left_out["span"])["theta"]["t"]) > 100
    broken = xr.Dataset({"voltage": ("time", np.arange(9.0), {"units": "V"})}, {"time": np.arange(9.0)})
    assert signals_of(broken).window(0, 9)["signals"][0]["unit"] == "V"


# who is answered


STRANGERS = ["/", "/ask/list", "/review.js", "/wrong/", "/wrong/ask/list", "/wrong/review.js", "/s3cret"]
STRANGERS += [
    "/wrong/bokeh.min.js",
    "/s3cre/",
    "/s3crett/ask/list",
    "/s3cret/../etc/passwd",
    "/s3cret/server.py",
]
STRANGERS += ["/open/s3cret", "/open/", "/s3cret/..%2Fserver.py", "/%F0%9F%98%80/"]


ASKED = ["record?test=tall&run=%C2%B2", "record?test=tall&run=1.5", "record", "list?x=1", "means?test="]
ASKED += ["window?test=tall&from_s=nan&to_s=1", "window?test=tall&from_s=1e300&to_s=1", "window?test=tall"]


def test_a_refused_save_leaves_both_files_and_a_table_that_is_away_is_one_line(desk, lab):
    own, known = correction(note="x"), desk.listing()["digest"]
    before, yaml = desk.csv.read_bytes(), desk.yaml.read_text()
    desk.yaml.write_text(yaml.replace("mass_kg:", "mass:"))
    with pytest.raises(FreerockError, match="mass"):
        desk.keep({"tall": own}, known, "heard")
    assert desk.csv.read_bytes() == before and not log_of(desk.csv).exists()
    desk.yaml.write_text(yaml)
    for spoil in (desk.csv.unlink, desk.csv.mkdir):
        spoil()
        for do in (lambda: desk.keep({"tall": own}, known, "heard"), lambda: desk.look("tall", 1, True)):
            with pytest.raises(
                FreerockError,
                match=r"small\.csv: can.*t be read .*; (put it back|write the file|put a file there)",
            ):
                do()
        with pytest.raises(FreerockError, match=r"small\.csv: can't be read .*; put it back"):
            desk.again()
    assert not log_of(desk.csv).exists()
