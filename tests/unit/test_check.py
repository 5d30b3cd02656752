"""freerock check: every problem of configuration and files at once, each with its file and line."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter

from freerock.cli import subcommands as cli
from freerock.cli.check_command import check_config
from freerock.files import sha256, write_manifest

ROOT = Path(__file__).parents[2]
YAML = """\
title: Blocks
origin: simulated
blocks:
  tall: {height_m: 0.28, width_m: 0.07, mass_kg: 5.84}
foundations:
  marble: {}
lasers:
  near: {beam: horizontal, position_m: 0.1, range_m: 0.05}
  table: {beam: horizontal, position_m: 0.1, calibration: table.csv}
"""
CSV = """\
test,file,channel,block,foundation,laser
a,a.tdms,,tall,marble,near
b,b.tdms,top,tall,marble,table
"""
RAMP = np.linspace(4, 6, 9)


def write_volts(path, unit, *channels, samples=RAMP):
    waveform = {"wf_increment": 1e-3, "wf_start_offset": 0.0, "unit_string": unit}
    with TdmsWriter(path) as writer:
        writer.write_segment([ChannelObject("g", name, samples, waveform) for name in channels])


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """A sound campaign in an empty folder."""
    monkeypatch.chdir(tmp_path)
    Path("config/campaigns").mkdir(parents=True)
    Path("raw/lab").mkdir(parents=True)
    Path("config/config.yaml").write_text("campaigns: [lab]\n")
    Path("config/campaigns/lab.yaml").write_text(YAML)
    Path("config/campaigns/lab.csv").write_text(CSV)
    write_volts("raw/lab/a.tdms", "V", "laser")
    write_volts("raw/lab/b.tdms", "V", "top", "low")
    Path("raw/lab/table.csv").write_text("V,mm\n0,0\n10,50\n")
    write_manifest("raw/lab", ["a.tdms"])
    return Path("raw/lab")


def edit(path, old, new):
    text = Path(path).read_text()
    assert old in text
    Path(path).write_text(text.replace(old, new))


def problems(**options):
    return [str(problem) for problem in check_config(**options)[1]]


@pytest.mark.parametrize("campaign", [None, "lab", "config/campaigns/lab.yaml"])
def test_a_sound_campaign(lab, campaign):
    assert check_config(campaign=campaign)[:2] == (["lab: 2 records"], [])


@pytest.mark.slow
def test_the_shipped_campaigns(monkeypatch):
    monkeypatch.chdir(ROOT)
    for path in Path("config/campaigns").glob("*.yaml"):
        _, found, notes = check_config(campaign=str(path))
        assert list(map(str, found)) == []
        assert notes == []


@pytest.mark.parametrize(
    ("name", "found", "doubted"),
    [("c", [], "a.tdms holds the signal of a too"), ("A", ["'A' is on line 2 already"], "")],
)
def test_a_file_that_stands_twice(lab, name, found, doubted):
    Path("config/campaigns/lab.csv").write_text(f"{CSV}{name},a.tdms,,tall,marble,near\n")
    _, problems, doubts = check_config()
    assert [each.what for each in problems] == found
    assert [each.what for each in doubts if "holds the signal" in each.what] == [doubted] * bool(doubted)


def missing_record(raw):
    (raw / "a.tdms").unlink()
    (raw / "manifest.csv").unlink()


def missing_and_listed(raw):
    (raw / "a.tdms").unlink()


def truncated(raw):
    whole = (raw / "b.tdms").read_bytes()
    (raw / "b.tdms").write_bytes(whole[:-20])


def no_raw(raw):
    shutil.rmtree(raw)


FILES = {
    "missing record": (
        missing_record,
        "config/campaigns/lab.csv:2: file: raw/lab/a.tdms: no such file; put it there, or correct its name",
    ),
    "truncated record": (
        truncated,
        "config/campaigns/lab.csv:3: file: raw/lab/b.tdms: the file is truncated: its last segment is "
        "incomplete; copy it again from the acquisition computer",
    ),
    "unknown channel": (
        lambda raw: edit("config/campaigns/lab.csv", "top", "tip"),
        "config/campaigns/lab.csv:3: channel: raw/lab/b.tdms: no channel 'tip'; its channels are top, low; "
        "name one (of a campaign in the channel column of its CSV)",
    ),
    "one of several channels": (
        lambda raw: edit("config/campaigns/lab.csv", "top", ""),
        "config/campaigns/lab.csv:3: channel: raw/lab/b.tdms: has the channels top, low; "
        "name one (of a campaign in the channel column of its CSV)",
    ),
    "unit other than declared": (
        lambda raw: edit("config/campaigns/lab.yaml", "0.05}", "0.05, units: mA}"),
        "config/campaigns/lab.csv:2: laser: 'mA' is declared and the file states 'V'; "
        "correct the one that is wrong, or name the channel that is meant",
    ),
    "no scale": (
        lambda raw: edit("config/campaigns/lab.yaml", ", range_m: 0.05", ""),
        "config/campaigns/lab.csv:2: laser: a voltage has no scale; "
        "give one of range_m, sensitivity_per_mm, calibration to the laser, or name another",
    ),
    "calibration that turns back": (
        lambda raw: edit(raw / "table.csv", "10,50", "10,50\n5,60"),
        "config/campaigns/lab.yaml:9: lasers.table.calibration: raw/lab/table.csv: the columns don't rise "
        "or fall throughout; give two lines or more, in order of the output",
    ),
    "no raw folder": (
        no_raw,
        "config/campaigns/lab.yaml: raw: there is no folder raw/lab; put the records there",
    ),
}


@pytest.mark.parametrize("mistake", FILES)
def test_a_problem_of_the_files_is_reported_with_its_line(lab, mistake):
    spoil, line = FILES[mistake]
    spoil(lab)
    assert problems() == [line]


def test_a_changed_record_is_reported_by_its_checksum(lab):
    listed = sha256(lab / "a.tdms")
    write_volts(lab / "a.tdms", "V", "laser", "laser_2")
    found = sha256(lab / "a.tdms")
    edit("config/campaigns/lab.csv", "a.tdms,,", "a.tdms,laser,")
    assert problems() == [
        f"raw/lab/a.tdms: has the sha256 {found}, raw/lab/manifest.csv lists {listed}; "
        "restore the file; if the change is meant: python -m freerock.files raw/lab"
    ]


def test_problems_of_configuration_and_files_are_reported_together(lab, capsys):
    edit("config/campaigns/lab.yaml", "mass_kg: 5.84", "mass_kg: -5.84")
    edit("config/campaigns/lab.csv", "top", "tip")
    (lab / "table.csv").write_text("")
    missing_record(lab)
    assert cli.main(["check"]) == 1
    printed = capsys.readouterr()
    assert printed.out == ""
    assert [line.split(": ")[:2] for line in printed.err.splitlines()] == [
        ["config/campaigns/lab.yaml:4", "blocks.tall.mass_kg"],
        ["config/campaigns/lab.csv:2", "file"],
        ["config/campaigns/lab.csv:3", "channel"],
    ]
    edit("config/campaigns/lab.yaml", "mass_kg: -5.84", "mass_kg: 5.84")
    assert len(problems()) == 3  # the calibration table, now that the lasers are known


def test_a_sample_that_cannot_be_read_is_a_problem_unless_its_record_is_excluded(lab, capsys):
    rows = [f"{i / 1000},{5.0}" for i in range(600)]
    rows[498] = "0.498,abc"
    (lab / "a.csv").write_text("\n".join(["time [s],laser [V]", *rows]) + "\n")
    write_manifest(lab, ["a.csv"])
    edit("config/campaigns/lab.csv", "a.tdms", "a.csv")
    assert cli.main(["check"]) == 1
    assert capsys.readouterr().err == (
        "config/campaigns/lab.csv:2: file: raw/lab/a.csv: line 500, column 2: 'abc' is not a number; "
        "correct the line, or export the file again\n"
    )
    edit("config/campaigns/lab.csv", "foundation,laser\n", "foundation,laser,exclude,reason\n")
    edit("config/campaigns/lab.csv", "marble,near\n", "marble,near,record,damaged file\n")
    edit("config/campaigns/lab.csv", "marble,table\n", "marble,table,,\n")
    assert problems() == []


def test_every_file_is_read_and_doubts_stand_beside_problems(lab):
    """Unknown block and laser, no number, other units, text, a file that is gone, thousandths of volts."""
    still = np.full(600, 5.0)
    swing = still + np.r_[np.zeros(300), np.sin(np.arange(300) / 20)]
    write_volts(lab / "nan.tdms", "V", "laser", samples=still * np.nan)
    write_volts(lab / "mm.tdms", "mm", "laser", samples=swing)
    write_volts(lab / "deg.tdms", "deg", "laser", samples=swing)
    write_volts(lab / "small.tdms", "V", "laser", samples=1e-3 * swing)
    rows = [f"{i / 1000},{volts}" for i, volts in enumerate([*swing[:-1], "lost"])]
    (lab / "text.csv").write_text("\n".join(["time [s],laser [V]", *rows]) + "\n")
    files = ["nan.tdms", "mm.tdms", "deg.tdms", "text.csv", "gone.tdms", "small.tdms"]
    tests = [f"{file.partition('.')[0]},{file},,tall,marble,near\n" for file in files]
    tests += ["c,a.tdms,,short,marble,near\n", "d,a.tdms,,tall,marble,far\n"]
    Path("config/campaigns/lab.csv").write_text(CSV + "".join(tests))
    sound, found, doubts = check_config()
    assert sound == []
    told = [str(each).removeprefix("config/campaigns/lab.csv:") for each in found]
    assert [line.split(": ")[0:2] for line in told] == [
        ["10", "block"],
        ["11", "laser"],
        ["4", "file"],
        ["5", "laser"],
        ["6", "laser"],
        ["7", "file"],
        ["8", "file"],
    ]
    assert "short" in told[0] and "'far'" in told[1] and "raw/lab/nan.tdms" in told[2]
    assert "range_m" in told[3] and "'mm'" in told[3] and "'deg'" in told[4]
    assert "'lost'" in told[5] and "line 601" in told[5] and "raw/lab/gone.tdms" in told[6]
    assert "config/campaigns/lab.csv:9: small" in [doubt.where for doubt in doubts]


def test_of_an_unreadable_yaml_nothing_else_is_told(lab):
    """Which folder holds the records is not known."""
    lab.rename("raw/other")
    edit("config/campaigns/lab.yaml", "origin: simulated", "raw: raw/other\norigin: simulated")
    edit("config/campaigns/lab.yaml", "mass_kg: 5.84}", "mass_kg: 5.84")
    (line,) = problems()
    assert line.startswith("config/campaigns/lab.yaml:5: ")


def test_a_table_of_volts_scales_no_length(lab):
    write_volts(lab / "b.tdms", "mm", "top", "low")
    (line,) = problems()
    assert line.startswith("config/campaigns/lab.csv:3: laser: ") and "calibration" in line and "'mm'" in line
    edit("config/campaigns/lab.yaml", ", calibration: table.csv", "")
    assert problems() == []
