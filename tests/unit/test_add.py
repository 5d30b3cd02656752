"""freerock add: records that join a campaign, all or none, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter

from freerock.cli import add_command
from freerock.cli import subcommands as cli
from freerock.config.campaign import load_campaign
from freerock.errors import FreerockError
from freerock.files import listed_checksums, sha256, write_manifest

YAML = """\
title: Blocks
origin: measured
blocks:
  tall: {height_m: 0.28, width_m: 0.07, mass_kg: 5.84}
  squat: {height_m: 0.14, width_m: 0.07, mass_kg: 2.98}
foundations:
  mat: {}
lasers:
  high: {beam: horizontal, position_m: 0.12, range_m: 0.1}
"""
HEADER = "test,file,channel,block,foundation,laser,exclude,override,reason,note"
FIRST = "first,first.tdms,,tall,mat,high,,,,"
CSV = Path("config/campaigns/lab.csv")
MANIFEST = Path("raw/lab/manifest.csv")


def write(path, **channels):
    """Channels as name=(unit, samples)."""
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [
                ChannelObject(
                    "g",
                    name,
                    np.asarray(values, float),
                    {"wf_increment": 1e-3, "wf_start_offset": 0.0, "unit_string": unit},
                )
                for name, (unit, values) in channels.items()
            ]
        )


@pytest.fixture(autouse=True)
def campaign(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for folder in ("config/campaigns", "raw/lab", "stick"):
        Path(folder).mkdir(parents=True)
    Path("config/campaigns/lab.yaml").write_text(YAML)
    CSV.write_text(f"{HEADER}\n{FIRST}\n")
    write("raw/lab/first.tdms", laser=("V", [5, 4]))
    write_manifest("raw/lab", ["first.tdms"])
    write("stick/second.tdms", laser=("V", [5, 3]))
    write("stick/third-1.tdms", laser=("V", [5, 2]), load=("N", [1, 2]))


def everything():
    """Bytes by file, but for the log."""
    return {path: path.read_bytes() for path in Path().rglob("*") if path.is_file() and path.name != cli.LOG}


def refused(capsys, *words):
    """The lines with which the command is refused; nothing is written then."""
    before = everything()
    assert cli.main(["add", "lab", *words]) == 1
    assert everything() == before
    return capsys.readouterr().err.splitlines()


def test_records_are_copied_listed_and_written_down(capsys):
    before = CSV.read_bytes()
    files = ["stick/second.tdms", "stick/third-1.tdms"]
    assert cli.main(["add", "lab", *files, "--block", "squat"]) == 0
    assert CSV.read_bytes() == before + (
        b"second,second.tdms,,squat,mat,high,,,,\nthird_1,third-1.tdms,laser,squat,mat,high,,,,\n"
    )
    for file in files:
        assert Path("raw/lab", Path(file).name).read_bytes() == Path(file).read_bytes()
    assert listed_checksums("raw/lab") == {
        name: sha256(f"raw/lab/{name}") for name in ("first.tdms", "second.tdms", "third-1.tdms")
    }
    assert MANIFEST.read_text().splitlines()[-1].endswith(f",{Path(files[1]).stat().st_size}")
    assert [record.test for record in load_campaign("config/campaigns/lab.yaml").records] == [
        "first",
        "second",
        "third_1",
    ]
    assert capsys.readouterr().out.endswith(
        "added: second, second.tdms, squat, mat, high\n"
        "added: third_1, third-1.tdms, laser, squat, mat, high\n"
        "next:  freerock check lab\n"
    )
    assert cli.main(["check", "lab"]) == 0


def test_a_file_without_times_has_the_rate_of_the_campaign(capsys):
    Path("stick/bare.csv").write_text("laser [V]\n5\n4\n3\n")
    (told,) = refused(capsys, "stick/bare.csv", "--block", "tall")
    assert told.endswith("sampling_rate_hz")
    with Path("config/campaigns/lab.yaml").open("a") as file:
        file.write("processing: {rotation: {sampling_rate_hz: 500}}\n")
    assert cli.main(["add", "lab", "stick/bare.csv", "--block", "tall"]) == 0
    assert "500 Hz" in capsys.readouterr().out and "bare.csv" in CSV.read_text()


def test_what_is_not_told_is_asked_for(capsys):
    Path("config/campaigns/lab.yaml").write_text(
        YAML.replace("  mat: {}", "  mat: {}\n  marble: {}")
        + "  low: {beam: horizontal, position_m: 0.05, range_m: 0.1}\n"
    )
    assert refused(capsys, "stick/second.tdms") == [
        "config/campaigns/lab.yaml: has the blocks tall, squat; say which with --block",
        "config/campaigns/lab.yaml: has the foundations mat, marble; say which with --foundation",
        "config/campaigns/lab.yaml: has the lasers high, low; say which with --laser",
    ]


@pytest.mark.parametrize(
    ("words", "place"),
    [
        (["stick/second.tdms", "--block", "tal"], "--block"),
        (["stick/gone.tdms", "--block", "tall"], "stick/gone.tdms"),
        (["stick/second.tdms", "stick/copy.tdms", "--block", "tall"], "stick/copy.tdms"),
        (["stick/first.tdms", "--block", "tall"], "stick/first.tdms"),
        (["stick/second.tdms", "--block", "tall", "--channel", "lazer"], "stick/second.tdms"),
        (["stick/third-1.tdms", "--block", "tall", "--channel", "load"], "stick/third-1.tdms"),
    ],
)
def test_what_can_not_be_added(capsys, words, place):
    Path("stick/copy.tdms").write_bytes(Path("stick/second.tdms").read_bytes())
    write("stick/first.tdms", laser=("V", [5, 8]))
    (line,) = refused(capsys, *words)
    assert line.startswith(f"{place}: ") and "; " in line


OTHERS = {
    "a length": ("mm", [5, 3], "'mm'"),
    "a rotation": ("deg", [5, 3], "'deg'"),
    "no number": ("V", [np.nan, np.nan], "no sample is a number"),
}


@pytest.mark.parametrize("case", OTHERS)
@pytest.mark.parametrize("words", [[], ["--channel", "laser"]])
def test_a_channel_that_is_not_the_lasers_is_refused(capsys, case, words):
    """The laser scales volts."""
    unit, samples, value = OTHERS[case]
    write("stick/other.tdms", laser=(unit, samples), heat=("°C", [20, 21]))
    (line,) = refused(capsys, "stick/other.tdms", "--block", "tall", *words)
    assert line.startswith("stick/other.tdms: channel laser") and value in line and "; " in line


def test_volts_are_refused_where_the_laser_has_no_scale(capsys):
    Path("config/campaigns/lab.yaml").write_text(YAML.replace(", range_m: 0.1", ""))
    (line,) = refused(capsys, "stick/second.tdms", "--block", "tall")
    assert line.startswith("stick/second.tdms: channel laser of laser high: ") and "range_m" in line


def test_why_a_channel_cannot_be_read_is_told(capsys):
    rows = [f"{i / 100},{i},{i if i != 400 else 'lost'}" for i in range(500)]
    Path("stick/text.csv").write_text("time [s],heat [°C],laser [V]\n" + "\n".join(rows) + "\n")
    for words in ([], ["--channel", "laser"]):
        (line,) = refused(capsys, "stick/text.csv", "--block", "tall", *words)
        assert line.startswith("stick/text.csv: channel laser: ")
        assert "line 402" in line and "'lost'" in line


def test_a_copy_that_fails_leaves_the_campaign_as_it_was(monkeypatch):
    before = CSV.read_bytes(), MANIFEST.read_bytes()

    def full(look, copy):
        raise FreerockError("disk", "is full", "free some space")

    monkeypatch.setattr(add_command, "take", full)
    assert cli.main(["add", "lab", "stick/second.tdms", "stick/third-1.tdms", "--block", "tall"]) == 1
    assert (CSV.read_bytes(), MANIFEST.read_bytes()) == before
