"""A plan compared with the ledger: what is missing, damaged or stale, and when a file is read."""

import dataclasses
import json
import os
import shutil
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from freerock.cli.verify_command import refusal
from freerock.errors import DamagedProduct, FreerockError
from freerock.jobs import contents, ledger, whole_or_rerun
from freerock.jobs.contents import checksum
from freerock.jobs.finish_campaign import complete
from freerock.jobs.ledger import at_work, entry_path, read_entry
from freerock.jobs.whole_or_rerun import (
    PlannedJob,
    compare,
    in_doubt,
    left_over,
    made_by_other_software,
    verified,
)

MADE = PlannedJob(
    "results/lab/logs/make.log",
    ["raw/a.tdms", "raw/b.tdms"],
    ["results/lab/x.nc", "results/lab/y.nc"],
    {"code": "1", "block": {"mass_kg": 2.0, "name": "tall"}},
)
READ = PlannedJob("results/lab/logs/read.log", ["results/lab/x.nc"], ["results/lab/z.csv"], {"code": "2"})


def do(step, **changes):
    """Do the job of a step: its products hold what its inputs hold."""
    step = dataclasses.replace(step, **changes)
    job = SimpleNamespace(log=[step.log], input=step.inputs, output=step.outputs, params=dict(step.settings))
    with at_work(job):
        for path in step.outputs:
            Path(path).write_text(path + "".join(Path(each).read_text() for each in step.inputs))


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """Two jobs done."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(ledger, "log_to", lambda path: None)
    for folder in ("raw", "results/lab/logs", ".snakemake"):
        (tmp_path / folder).mkdir(parents=True)
    for name in "ab":
        (tmp_path / f"raw/{name}.tdms").write_text(name)
    do(MADE)
    do(READ)
    return tmp_path


def states(found=None, **options):
    """State and reason by path."""
    found = found or compare([READ, MADE], **options)
    return {
        each.path: (each.state, each.why, each.derived) for doubts in found.doubts.values() for each in doubts
    }


def rewrite(path, change):
    """Change a file's bytes, its size and its time as they were."""
    before = path.stat()
    path.write_bytes(change(path.read_bytes()))
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert (path.stat().st_size, path.stat().st_mtime_ns) == (before.st_size, before.st_mtime_ns)


def test_what_a_run_has_made_is_whole(lab):
    found = compare([MADE, READ])
    assert not found.doubts and not found.again and not in_doubt(found)
    assert verified(found, Path("results/lab"))[1]


@pytest.mark.parametrize("noted", [True, False])
@pytest.mark.parametrize(
    ("damage", "state"),
    [
        (lambda path: path.unlink(), "missing"),
        (lambda path: path.write_bytes(b""), "damaged"),
        (lambda path: path.write_bytes(path.read_bytes()[:-1]), "damaged"),
        (lambda path: rewrite(path, lambda data: bytes([data[0] ^ 1]) + data[1:]), "damaged"),
        (lambda path: shutil.copy2("results/lab/y.nc", path), "damaged"),
    ],
    ids=["deleted", "emptied", "cut", "byte flipped, time restored", "another in its place"],
)
def test_damage_is_found_however_it_looks(lab, damage, state, noted):
    if noted:
        compare([MADE, READ]).contents.note()
    damage(lab / "results/lab/x.nc")
    found = compare([MADE, READ])
    assert states(found)["results/lab/x.nc"][0] == state
    assert states(found)["results/lab/z.csv"] == ("stale", "was made from results/lab/x.nc", True)
    assert found.again == {MADE.log, READ.log}
    assert in_doubt(found)[0].startswith("results/lab/x.nc is ")


def test_another_record_under_an_old_time_is_found(lab):
    compare([MADE, READ]).contents.note()
    rewrite(lab / "raw/a.tdms", lambda data: b"A")
    assert states()["results/lab/x.nc"] == ("stale", "was made from another raw/a.tdms", False)
    assert compare([READ]).doubts == {}  # of what is asked for nothing is stale


def test_a_record_given_back_is_known_again(lab):
    original = (lab / "raw/a.tdms").read_bytes()
    (lab / "raw/a.tdms").write_bytes(b"other")
    do(MADE)
    assert {path for path, _ in states().items()} == {"results/lab/z.csv"}
    (lab / "raw/a.tdms").write_bytes(original)
    os.utime(lab / "raw/a.tdms", (1e9, 1e9))
    assert states()["results/lab/x.nc"] == ("stale", "was made from another raw/a.tdms", False)


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        (
            {"settings": {"code": "1", "block": {"mass_kg": 3.0, "name": "tall"}}},
            "by other settings (block.mass_kg 2, now 3)",
        ),
        (
            {"settings": {"code": "1", "block": {"name": "tall"}}},
            "by other settings (block.mass_kg 2, now nothing)",
        ),
        ({"settings": MADE.settings | {"code": "3"}}, "by other code"),
        ({"inputs": ["raw/a.tdms"]}, "from other files (raw/b.tdms)"),
        ({"inputs": ["raw/b.tdms", "raw/a.tdms"]}, "from other files (raw/b.tdms, raw/a.tdms)"),
    ],
)
def test_made_otherwise(lab, changes, why):
    found = compare([dataclasses.replace(MADE, **changes)])
    assert states(found) == {path: ("stale", f"was made {why}", False) for path in MADE.outputs}


def test_products_of_another_campaign_are_not_taken_for_ones_own(lab):
    """The whole folder copied over, ledger and all."""
    os.rename(lab / "results/lab", lab / "results/other")
    steps = [
        PlannedJob(
            step.log.replace("lab", "other"),
            *([path.replace("lab", "other") for path in paths] for paths in (step.inputs, step.outputs)),
            step.settings,
        )
        for step in (MADE, READ)
    ]
    found = compare(steps)
    assert found.again == {step.log for step in steps}


def test_without_an_entry_nothing_is_taken_for_whole(lab):
    entry_path(MADE.log).unlink()
    assert states()["results/lab/x.nc"] == ("stale", "has no entry in the ledger", False)


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: b"",
        lambda data: data[: len(data) // 2],
        lambda data: b"[]",
        lambda data: b"[" * 100_000,
        lambda data: data.replace(b"outputs", b"0utputs"),
        lambda data: json.dumps(json.loads(data) | {"looks": {"raw/a.tdms": [1]}}).encode(),
        lambda data: json.dumps(json.loads(data) | {"looks": {"raw/a.tdms": [[], 1, 1, 1]}}).encode(),
        lambda data: json.dumps(json.loads(data) | {"inputs": {"raw/a.tdms": [1]}}).encode(),
        lambda data: json.dumps(json.loads(data) | {"settings": 3}).encode(),
    ],
)
def test_a_damaged_entry_is_none(lab, damage):
    path = entry_path(MADE.log)
    path.write_bytes(damage(path.read_bytes()))
    assert read_entry(path) is None
    assert compare([MADE, READ]).again == {MADE.log}


def test_a_thorough_look_reads_every_file(lab, monkeypatch):
    time.sleep(0.03)
    compare([MADE, READ]).contents.note()
    read = []
    monkeypatch.setattr(contents, "checksum", lambda path: read.append(path) or checksum(path))
    assert not compare([MADE, READ], thorough=True).doubts
    assert sorted(read) == sorted({*MADE.inputs, *MADE.outputs, *READ.outputs})


def test_an_input_changed_under_a_job_ends_it_without_an_entry(lab):
    entry_path(MADE.log).unlink()
    job = SimpleNamespace(log=[MADE.log], input=MADE.inputs, output=MADE.outputs, params=dict(MADE.settings))
    with pytest.raises(FreerockError) as told, at_work(job):
        rewrite(lab / "raw/a.tdms", lambda data: b"A")
    assert str(told.value) == "raw/a.tdms: was changed while it was being read; run the same command again"
    assert not entry_path(MADE.log).exists()


@pytest.mark.parametrize(
    ("path", "damage"),
    [
        ("results/lab/x.nc", lambda path: path.write_bytes(b"")),
        ("results/lab/x.nc", lambda path: rewrite(path, lambda data: data[:-1] + b"A")),
        ("results/lab/x.nc", lambda path: shutil.copy2("results/lab/y.nc", path)),
    ],
    ids=["emptied", "byte flipped, time restored", "another in its place"],
)
def test_nothing_is_made_from_a_damaged_product(lab, path, damage):
    """However the bytes fall, and whatever was seen when the run began."""
    damage(lab / path)
    entry_path(READ.log).unlink()
    with pytest.raises(DamagedProduct, match=rf"^{path}: is not as it was written; delete the file"):
        do(READ)
    assert not entry_path(READ.log).exists()


def test_any_of_several_entries_vouches_for_a_product(lab):
    """Records that shared a job once: its entry is still there."""
    shutil.copy(entry_path(MADE.log), entry_path(MADE.log).with_stem("older"))
    (lab / "raw/a.tdms").write_text("other")
    do(MADE)
    do(READ)
    assert not compare([MADE, READ]).doubts


def test_a_job_that_fails_leaves_no_entry(lab):
    entry_path(READ.log).unlink()
    job = SimpleNamespace(log=[READ.log], input=READ.inputs, output=READ.outputs, params={})
    with pytest.raises(ZeroDivisionError), at_work(job):
        raise ZeroDivisionError
    assert not entry_path(READ.log).exists()


def test_other_software_is_named_and_makes_nothing_stale(lab, monkeypatch):
    assert made_by_other_software(compare([MADE, READ]).entries.values()) == ""
    now = ledger.software()
    monkeypatch.setattr(whole_or_rerun, "software", lambda: now | {"numpy": "1.0"})
    found = compare([MADE, READ])
    told = f"3 products were made by other software (numpy {now['numpy']}, now 1.0)"
    assert not found.doubts and made_by_other_software(found.entries.values()) == told
    assert verified(found, Path("results/lab")) == (
        [f"software: {told}", "results/lab: 3 whole, 0 missing, 0 damaged, 0 stale, 0 foreign"],
        True,
    )


def test_verification_names_each_product_and_each_foreign_file(lab):
    (lab / "results/lab/x.nc").unlink()
    (lab / "results/lab/y.nc").write_text("cut")
    for folder in ("figures", "plan"):
        (lab / "results/lab" / folder).mkdir()
    beside = (".hidden", "figures/.hidden", "quick_look.png", "plan/plan.csv")
    for path in ("figures/old.pdf", "logs/old.log", *beside):
        (lab / "results/lab" / path).touch()
    lines, whole = verified(compare([MADE, READ]), Path("results/lab"))
    assert not whole
    assert lines == [
        "missing: results/lab/x.nc",
        "damaged: results/lab/y.nc",
        "stale: results/lab/z.csv was made from results/lab/x.nc",
        "foreign: results/lab/figures/old.pdf",
        "results/lab: 0 whole, 1 missing, 1 damaged, 1 stale, 1 foreign",
    ]
    assert left_over(Path("results/lab"), {"results/lab/x.nc"}) == ["figures/old.pdf", "y.nc", "z.csv"]


RUNS = """\
test,run,verdict,excluded,reasons
a,1,fail,False,few
a,2,fail,True,slid
b,,fail,,nothing moves; check the channel
c,1,ok,False,
c,2,fail,False,few
"""


def test_verification_names_records_that_failed_while_the_table_that_says_so_is_whole(lab):
    table, ended = "results/lab/tables/runs.csv", "results/lab/complete.txt"
    step = PlannedJob("results/lab/logs/tables.log", [], [table], {})
    steps = [MADE, READ, step, PlannedJob("results/lab/logs/complete.log", [table], [ended], {})]
    Path(table).parent.mkdir()
    with at_work(SimpleNamespace(log=[step.log], input=[], output=[table], params={})):
        Path(table).write_text(RUNS)
    lines, whole = verified(compare(steps), Path("results/lab"))
    assert not whole
    assert lines == [
        f"missing: {ended}",
        "failed: record a: few",
        "failed: record b: nothing moves; check the channel",
        "results/lab: 4 whole, 1 missing, 0 damaged, 0 stale, 0 foreign",
    ]
    with pytest.raises(SystemExit):
        complete("lab", table, ended)
    Path(table).write_text(RUNS.replace("fail", "ok"))
    told, _ = verified(compare(steps), Path("results/lab"))
    assert "failed" not in "".join(told)
    Path(table).write_text("\n".join([*RUNS.splitlines()[:1], "c,1,ok,False,", ""]))
    complete("lab", table, ended)
    assert Path(ended).read_text() == "1 record, 1 run\n"


@pytest.mark.parametrize(
    ("told", "campaigns", "remedy"),
    [
        ("missing: x\n", [], "run snakemake"),
        ("stale: x\nforeign: y\n", ["a", "b"], "run snakemake --config campaigns=[a,b], and delete what is "),
        (
            "failed: record a: few\n",
            ["a"],
            "correct or exclude each record that failed, and run snakemake --config campaigns=a",
        ),
    ],
)
def test_the_remedy_is_for_what_a_verification_tells(told, campaigns, remedy):
    found = refusal("results", campaigns, told).remedy
    assert found.removesuffix("foreign") == remedy
