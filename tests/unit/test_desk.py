"""The review desk without a browser: what it tries is what the jobs write; what it keeps; who it answers."""

import asyncio
import csv
import json
import shutil

import lmfit
import numpy as np
import pytest
import xarray as xr
from small_campaign import BLOCKS, CAMPAIGN, COLUMNS, MAT
from tornado.httpclient import AsyncHTTPClient, HTTPRequest
from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets

from freerock import bounds
from freerock.config.review_log import Change, appended, log_of, looked_at, read_changes
from freerock.errors import FreerockError
from freerock.jobs.each_record import make_each
from freerock.jobs.make_fits import give_up_fits, make_fits
from freerock.jobs.make_record import make_record, rotation_of
from freerock.models.block import Block
from freerock.models.laws import PAPER_MODELS
from freerock.models.simulate import simulate
from freerock.products.groups import fits_of, not_fitted_in
from freerock.products.netcdf import open_fits, open_record
from freerock.review import server
from freerock.review.corrections import Correction, corrected, corrected_cells
from freerock.review.desk import Desk
from freerock.review.pictures import impact_speed
from freerock.review.reprocessing import Superseded
from freerock.review.signals import signals_of
from freerock.tables.number_text import quantity
from freerock.tables.populations import populations_table
from freerock.tables.printed_tables import table2_text
from freerock.tables.summary import table2
from freerock.tables.tidy_tables import contributions_table, parameters_table, restitution_table, runs_table
from freerock.virtual_lab.virtual_record import Recording, VirtualRelease, simulate_record
from freerock.virtual_lab.write_tdms import write_records

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
    yaml = CAMPAIGN.replace("truth: truth.json\n", "")
    (folder / "config/campaigns/small.yaml").write_text(yaml)
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
        if model != "choice"
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
        make_each(
            ["tall"],
            lambda _: make_fits(told, tmp_path / "r.nc", product),
            lambda _, reason: give_up_fits(told, product, reason),
        )
        return open_fits(product)

    return run


def test_the_date_of_a_record_reaches_its_product(desk, tmp_path):
    of_record, _ = desk._bench.settings(desk.campaign, desk.campaign.record("tall"))
    make_record(of_record, tmp_path / "r.nc")
    assert open_record(tmp_path / "r.nc").attrs["time_coverage_start"] == "2017-05-02T09:00:00.000Z"


@pytest.mark.parametrize("error", [FreerockError("lmfit", "is out of order", "mend it"), ValueError("NaN")])
def test_without_lmfit_no_fit_of_the_job_succeeds_and_each_says_so_in_a_line(job, monkeypatch, error):
    def refuse(*_, **__):
        raise error

    monkeypatch.setattr(lmfit, "Minimizer", refuse)
    tree = job()
    assert not list(fits_of(tree))
    missed = not_fitted_in(tree.attrs)
    assert missed and all("\n" not in each.text and str(error) in each.text for each in missed)
    if isinstance(error, FreerockError):
        runs_and_laws = {(each.run, each.text.partition(" ")[0]) for each in missed}
        assert runs_and_laws >= {(run, law) for run in (1, 2) for law in PAPER_MODELS}
    else:  # an unforeseen one ends the record
        assert len(missed) == 1 and tree.attrs["verdict"] == "fail"


def test_what_is_given_of_parameters_reaches_the_product_and_table_2(job, caplog):
    given = {"winkler": {"c": {"expr": "3e-3*k"}}, "hunt_crossley": {"k": {"value": MAT["k"], "vary": False}}}
    with caplog.at_level("INFO", "freerock"):
        tree = job(options={"parameters": given})
    fits = {(run, model): fit for run, model, fit in fits_of(tree)}
    for run in (1, 2):
        tied, fixed = fits[run, "winkler"], fits[run, "hunt_crossley"]
        assert tied["vary"].values.tolist() == [1, 0, 1, 1] and tied["expr"].values[1] == "3e-3*k"
        np.testing.assert_allclose(tied["value"].values[1], 3e-3 * tied["value"].values[0])
        assert fixed["value"].values[0] == MAT["k"] and fixed["n_parameters"] == 3
        judged = tree[f"run_{run}/choice"].dataset["n_freed"]
        for model in ("winkler", "winkler_pivoting", "hunt_crossley"):
            assert judged.sel(candidate=model) == 3
    parameters = parameters_table([tree])
    table = table2(populations_table(parameters, contributions_table([tree])), parameters)
    rows = {(row.model, row.parameter): row for row in table.itertuples()}
    assert rows["winkler", "c"].given == "tied: 3e-3*k" and rows["hunt_crossley", "k"].given == "fixed"
    assert rows["hunt_crossley", "k"].n_runs == 2
    text = table2_text(table)["Identified"]
    assert text.str.contains("(tied)", regex=False).sum() == 1
    assert "2.86·10⁶ (fixed)" in text.tolist()
    assert "[[Variables]]" in caplog.text and "(fixed)" in caplog.text


def test_a_correction_gives_what_the_jobs_write(desk, tmp_path):
    seen = desk.record("tall", 1)["picture"]
    own = correction(overrides=moved(1, seen["release"] + 0.02, seen["end"]), reason="late")
    tried = desk.refit("tall", own, 1, seen["release"], whole=False)
    whole = desk.refit("tall", own, 1, seen["release"], whole=True)
    line = desk.campaign.record("tall")
    of_record, of_fits = desk._bench.settings(desk.campaign, corrected(line, corrected_cells(own, line)))
    make_record(of_record, tmp_path / "r.nc")
    make_fits(of_fits, tmp_path / "r.nc", tmp_path / "f.nc")
    assert parameters(tried["picture"]) == numbers_in(tmp_path / "f.nc", "run_1")
    assert parameters(whole["picture"]) == numbers_in(tmp_path / "f.nc", "run_1")
    (row,) = runs_table([open_record(tmp_path / "r.nc")])[:1].itertuples()
    assert row.theta0_u_deg > 0
    for each in (tried, whole):
        theta0 = quantity(row.theta0_deg, row.theta0_u_deg)  # as report and quality page print it
        assert each["picture"]["facts"][0] == ["θ₀", f"{theta0}°"]
    fits = [open_fits(tmp_path / "f.nc")]
    means = populations_table(parameters_table(fits), contributions_table(fits))
    assert parameters(whole["picture"], "means") == {
        (row.model, row.parameter): (
            f"{row.mean:.10g}",
            f"{row.u_total:.10g}" if np.isfinite(row.u_total) else "",
        )
        for row in means[means["level"] == "record"].itertuples()
    }
    assert whole["cells"] == {"override": corrected_cells(own, line)["override"], "reason": "late"}


def test_the_misfit_map_is_least_at_what_was_identified(desk):
    desk.refit("tall", correction(), 1, None, whole=True)
    found = desk.misfit("tall", 1, correction())
    epsilon = np.array(found["epsilon"])
    row, column = np.unravel_index(epsilon.argmin(), epsilon.shape)
    assert found["names"] == ["k", "λ"]
    assert abs(row - epsilon.shape[0] // 2) <= 3 and abs(column - epsilon.shape[1] // 2) <= 3
    assert desk.misfit("lost", 1, correction()) == {}


def test_an_excluded_run_leaves_the_mean(desk):
    before = desk.refit("tall", correction(), 1, None, whole=True)
    after = desk.refit("tall", correction(exclude=[2], reason="knocked"), 1, None, whole=True)
    assert [row["excluded"] for row in after["rows"]] == [False, True]
    assert parameters(after["picture"]) == parameters(before["picture"])
    assert parameters(after["picture"], "means") != parameters(before["picture"], "means")


def test_what_stands_in_a_stretch_left_out_reaches_no_number(desk, lab, tmp_path):
    """The jobs' fits are the same bits whether the laser was hit within the stretch or not."""
    run = desk.record("tall", 1)["picture"]
    at = run["impacts"]["measured"][3][0]
    stretches = [[at - 0.05, at + 0.03], [run["impacts"]["measured"][0][0]] * 2]
    own = correction(stretches=stretches, reason="hit")
    line = desk.campaign.record("tall")
    tried = desk.refit("tall", own, 1, run["release"], whole=True)
    assert [each["text"].endswith("left out: hit") for each in tried["picture"]["reasons"]] == [True, True]
    assert [row["verdict"] for row in tried["rows"]] == ["ok", "ok"]
    of_record, of_fits = desk._bench.settings(desk.campaign, corrected(line, corrected_cells(own, line)))
    rotation = rotation_of(of_record)
    hit = rotation.assign(theta=rotation["theta"] + 0.1 * (abs(rotation["time"] - at) < 0.025))
    for name, seen in (("clean", rotation), ("hit", hit)):
        make_record(of_record, tmp_path / f"{name}.nc", lambda _, seen=seen: seen)
        make_fits(of_fits, tmp_path / f"{name}.nc", tmp_path / f"{name}_fits.nc")
    assert parameters(tried["picture"]) == numbers_in(tmp_path / "hit_fits.nc", "run_1")
    assert numbers_in(tmp_path / "hit_fits.nc", "run_1") == numbers_in(tmp_path / "clean_fits.nc", "run_1")
    r = open_record(tmp_path / "hit.nc")["run_1"]["restitution"].values
    assert np.isnan(r).tolist() == [True, False, True, True, True]
    table = restitution_table([open_record(tmp_path / "hit.nc")], [])
    assert table["r"].isna().tolist() == np.isnan(r).tolist() + [False] * (len(table) - len(r))
    flags = open_record(tmp_path / "hit.nc")["flags"]
    hidden = np.flatnonzero(flags.values & 64)
    assert flags.attrs["flag_meanings"].split()[-1] == "left_out" and hidden.size == pytest.approx(40, abs=2)


def test_what_is_no_longer_needed_ends(desk):
    with pytest.raises(Superseded):
        desk.refit("tall", correction(), 1, None, whole=True, needed=lambda: False)


def test_what_was_kept_meanwhile_outlives_an_older_fit(desk, monkeypatch):
    def slow(campaign, line, *_):
        desk.keep({"tall": correction(exclude=[2], reason="knocked")}, desk.listing()["digest"], "")
        return desk._bench.process(campaign, line)

    monkeypatch.setattr(desk._bench, "analyse", slow)
    desk.refit("tall", correction(), 1, None, whole=True)
    assert [row["excluded"] for row in desk.record("tall", 1)["runs"]] == [False, True]


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


def test_undo_leaves_what_others_changed_since(desk, lab):
    path = lab / "config/campaigns/small.csv"
    desk.keep({"tall": correction(note="mine")}, desk.listing()["digest"], "heard")
    path.write_bytes(path.read_bytes() + b"# theirs\n")
    with pytest.raises(FreerockError, match="was changed by someone else"):
        desk.undo()
    desk.again()
    desk.undo()
    assert path.read_text().endswith("# theirs\n")
    assert cell(lab, "note") == ""


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


def test_a_cell_that_says_the_same_stays_as_it_is(desk, lab):
    path = lab / "config/campaigns/small.csv"
    path.write_text(path.read_text().replace("high,,,,", "high,2;1,1@5:9 ; 2@ 15.0:19,both,"))
    desk.again()
    line = desk.campaign.record("tall")
    own = desk.record("tall", 1)["correction"]
    assert corrected_cells(correction(**own), line) == {}
    assert corrected_cells(correction(**own | {"note": "x"}), line) == {"note": "x"}


def test_a_failed_record_and_one_left_out_are_seen(desk, lab):
    assert "lost.tdms" in desk.record("lost", None)["failure"]
    desk.keep({"tall": correction(exclude="record", reason="wet")}, desk.listing()["digest"], "")
    left_out = desk.record("tall", None)
    assert left_out["failure"] == "excluded: wet"
    assert len(desk.window("tall", *left_out["span"])["theta"]["t"]) > 100
    broken = xr.Dataset({"voltage": ("time", np.arange(9.0), {"units": "V"})}, {"time": np.arange(9.0)})
    assert signals_of(broken).window(0, 9)["signals"][0]["unit"] == "V"


def test_a_look_holds_until_the_record_is_corrected(desk):
    desk.record("tall", 1)
    desk.look("tall", 1, True)
    assert [bool(row["looked"]) for row in desk.listing()["rows"]][:1] == [True]
    log = read_changes(log_of(desk.csv))
    assert set(looked_at(log)) == {("tall", "1")}
    desk.keep({"tall": correction(exclude=[2], reason="x")}, desk.listing()["digest"], "")
    assert looked_at(read_changes(log_of(desk.csv))) == {}


def test_a_line_of_the_log_that_was_cut_short_spoils_no_other(tmp_path):
    path = tmp_path / "a.review.csv"
    lines = [Change("t", "me", "a", "", "note", "", 'x, "y"\u2028', "z"), Change(*"abcdefgh")]
    torn = [b"t,me,half", b't,me,a,,note,,"half a quote', b"t,me,a,,note,,\xc3", b"t,me," + b"x" * 200_000]
    content = b""
    for line in torn:
        content = appended(content, lines[:1]) + line
    path.write_bytes(appended(content, lines[1:]))
    assert read_changes(path) == [*lines[:1] * len(torn), *lines[1:]]


def test_an_entry_of_the_log_is_one_line(tmp_path):
    content = appended(b"", [Change("t", "me", "a", "", "override", "1@2:3;\r\n2@4:5", "", "why")])
    assert content.count(b"\n") == 2 and b"\r" not in content


def test_a_window_keeps_every_extreme_of_ten_minutes():
    n = 600 * 1000
    time = np.arange(n) / 1000
    theta = 1e-3 * np.sin(time)
    theta[[123_456, 543_210]] = 0.5, -0.25
    flags = np.zeros(n, np.uint8)
    flags[[7, 300_000]] = 2, 32
    record = xr.Dataset(
        {"theta": ("time", theta), "flags": ("time", flags), "voltage": ("time", theta.astype("f4"))},
        {"time": time},
    )
    signals = signals_of(record)
    seen = signals.window(0.0, 600.0)
    assert len(seen["theta"]["t"]) <= 1800
    assert max(seen["theta"]["v"]) == pytest.approx(np.degrees(0.5))
    assert min(seen["theta"]["v"]) == pytest.approx(np.degrees(-0.25))
    assert [each[2] for each in seen["flags"]] == ["out of range", "spike"]
    near = signals.window(123.45, 123.46)
    assert 123.456 in near["theta"]["t"]
    assert len(near["theta"]["t"]) <= 13


def test_the_speed_at_an_impact_is_that_of_free_rocking():
    """Against Housner's closed form of the motion, by a difference quotient at its first impact."""
    block, theta0 = Block(0.28, 0.07, 5.84), 0.02
    time = np.linspace(0.0, 0.5, 500_001)
    theta = simulate("housner", block, {"r": 1.0}, time, theta0=theta0).theta
    first = int(np.argmax(theta < 0))
    rate = abs(theta[first - 1] - theta[first - 101]) / (100 * (time[1] - time[0]))
    assert impact_speed(np.array([theta0]), block)[0] == pytest.approx(rate, rel=5e-3)


# who is answered


def asked(desk, *requests):
    """Status, headers and body of requests to the desk's server; PORT and TOKEN are filled in."""

    async def serve():
        sockets = bind_sockets(0, server.HOST)
        http = HTTPServer(server.application(desk, "s3cret", "first"), max_buffer_size=bounds.REQUEST_BYTES)
        http.add_sockets(sockets)
        port, client, found = sockets[0].getsockname()[1], AsyncHTTPClient(), []
        assert [each.getsockname()[0] for each in sockets] == ["127.0.0.1"]
        for path, more in requests:
            url = f"http://127.0.0.1:{port}{path}"
            found.append(await client.fetch(HTTPRequest(url, **more), raise_error=False))
        http.stop()
        return [(each.code, each.headers, each.body) for each in found]

    return asyncio.run(serve())


STRANGERS = ["/", "/ask/list", "/review.js", "/wrong/", "/wrong/ask/list", "/wrong/review.js", "/s3cret"]
STRANGERS += [
    "/wrong/bokeh.min.js",
    "/s3cre/",
    "/s3crett/ask/list",
    "/s3cret/../etc/passwd",
    "/s3cret/server.py",
]
STRANGERS += ["/open/s3cret", "/open/", "/s3cret/..%2Fserver.py", "/%F0%9F%98%80/"]


@pytest.mark.parametrize("path", STRANGERS)
def test_without_the_token_nothing_is_served(desk, path):
    ((status, _, body),) = asked(desk, (path, {}))
    assert (status, body) == (404, b"404")


def test_the_address_that_opens_the_browser_leads_to_the_page_once(desk):
    still = {"follow_redirects": False}
    first, again = asked(desk, ("/open/first", still), ("/open/first", still))
    assert (first[0], first[1]["Location"]) == (302, "/s3cret/")
    assert again[0] == 404
    wrong, late = asked(desk, ("/open/guess", still), ("/open/first", still))
    assert (wrong[0], late[0]) == (404, 404)


def test_a_page_of_another_name_or_form_is_refused(desk):
    post = {"method": "POST", "body": "{}"}
    found = asked(
        desk,
        ("/s3cret/ask/list", {"headers": {"Host": "evil.example:80"}}),
        ("/s3cret/do/undo", post | {"headers": {"Content-Type": "text/plain"}}),
        ("/wrong/do/undo", post | {"headers": {"Content-Type": "application/json"}}),
        ("/s3cret/do/undo", {}),
        ("/s3cret/do/refit", post | {"headers": {"Content-Type": "application/json"}}),
        ("/s3cret/do/undo", post | {"headers": {"Content-Type": "application/json"}}),
    )
    assert [status for status, *_ in found] == [404, 415, 404, 405, 400, 409]
    assert "nothing was saved" in json.loads(found[-1][2])["error"]


RIGHT = {"test": "tall", "correction": BLANK, "run": None, "near_s": None, "whole": True}
KEPT = {"corrections": {"tall": BLANK}, "known": "0" * 64, "why": ""}
BEYOND = {"run": 1, "release_s": 1e400, "end_s": 2, "hold_s": None}


def kept(**own):
    return "keep", KEPT | {"corrections": {"tall": BLANK | own}}


WRONG = [  # request, and the field that its answer names
    ("refit", RIGHT | {"test": 3}, "test"),
    ("refit", RIGHT | {"run": "1"}, "run"),
    ("refit", RIGHT | {"run": 1.9}, "run"),
    ("refit", RIGHT | {"run": True}, "run"),
    ("refit", RIGHT | {"near_s": "early"}, "near_s"),
    ("refit", RIGHT | {"correction": []}, "correction"),
    ("refit", RIGHT | {"more": 1}, "more"),
    ("refit", RIGHT | {"whole": 1}, "whole"),
    ("misfit", {"test": "tall", "run": 1.5, "correction": BLANK}, "run"),
    ("misfit", {"test": "tall", "run": 1, "correction": {"exclude": []}}, "correction.overrides"),
    ("keep", KEPT | {"corrections": ["tall"]}, "corrections"),
    ("keep", KEPT | {"known": "x"}, "known"),
    ("keep", KEPT | {"why": "x" * 131_073}, "why"),
    ("keep", {"corrections": {}, "why": ""}, "known"),
    (*kept(exclude="12"), "corrections.tall.exclude"),
    (*kept(exclude=[True]), "corrections.tall.exclude.0"),
    (*kept(exclude=[0]), "corrections.tall.exclude.0"),
    (*kept(reason=["wet"]), "corrections.tall.reason"),
    (*kept(note="x" * 131_073), "corrections.tall.note"),
    (*kept(overrides=[BEYOND]), "corrections.tall.overrides.0.release_s"),
    (*kept(overrides=[BEYOND | {"release_s": 1, "hold_s": [1]}]), "corrections.tall.overrides.0.hold_s"),
    (*kept(overrides=[BEYOND | {"release_s": 1, "run": 1.9}]), "corrections.tall.overrides.0.run"),
    ("look", {"test": "tall", "run": 1, "seen": "yes"}, "seen"),
    ("undo", [], ""),
    ("undo", {"test": "tall"}, "test"),
]
ENDLESS = "[" * 50_000 + "]" * 50_000
ASKED = ["record?test=tall&run=%C2%B2", "record?test=tall&run=1.5", "record", "list?x=1", "means?test="]
ASKED += ["window?test=tall&from_s=nan&to_s=1", "window?test=tall&from_s=1e300&to_s=1", "window?test=tall"]


def test_a_request_of_another_form_is_refused_by_its_field(desk):
    told = {"method": "POST", "headers": {"Content-Type": "application/json"}}
    requests = [(f"/s3cret/do/{what}", told | {"body": json.dumps(given)}) for what, given, _ in WRONG]
    for (status, _, body), (_, _, field) in zip(asked(desk, *requests), WRONG, strict=True):
        where, *_ = json.loads(body)["error"].partition(": ")
        assert (status, where) == (400, f"request.{field}" if field else "request")
    bodies = [b"", b"{", ENDLESS.encode(), b'{"test": ' + ENDLESS.encode() + b"}", b"\xff", b"NaN"]
    found = asked(desk, *(("/s3cret/do/undo", told | {"body": body}) for body in bodies))
    assert [status for status, *_ in found] == [400] * len(bodies)
    found = asked(desk, *((f"/s3cret/ask/{path}", {}) for path in ASKED))
    assert [status for status, *_ in found] == [*[400] * 4, 409, *[400] * 3]
    assert not log_of(desk.csv).exists()


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


def test_no_page_may_load_from_elsewhere(desk):
    page, script, listing = asked(
        desk, ("/s3cret/", {}), ("/s3cret/bokeh.min.js", {}), ("/s3cret/ask/list", {})
    )
    assert [each[0] for each in (page, script, listing)] == [200, 200, 200]
    assert b"http" not in page[2]
    for _, headers, _ in (page, script, listing):
        policy = dict(part.split(" ", 1) for part in headers["Content-Security-Policy"].split("; "))
        assert policy["default-src"] == "'none'"
        assert {policy[key] for key in ("script-src", "connect-src")} == {"'self'"}
        assert headers["Referrer-Policy"] == "no-referrer"
    rows = json.loads(listing[2])["rows"]
    assert [row["test"] for row in rows] == ["tall", "lost"]
