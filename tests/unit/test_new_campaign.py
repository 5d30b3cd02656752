"""freerock inspect and new-campaign: what a folder of records shows, and what it leaves to be filled in."""

import re
from pathlib import Path

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter
from openpyxl import Workbook

from freerock.cli import subcommands as cli
from freerock.cli.inspect_command import look_into, look_text
from freerock.config.campaign import load_campaign
from freerock.config.mistakes import FILL_IN, ConfigError
from freerock.files import listed_checksums, sha256

FOLDER = Path("stick/day 1")


def write(path, rate, **channels):
    """Channels as name=(unit, samples)."""
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [
                ChannelObject(
                    "g",
                    name,
                    np.asarray(values, float),
                    {"wf_increment": 1 / rate, "wf_start_offset": 0.0, "unit_string": unit},
                )
                for name, (unit, values) in channels.items()
            ]
        )


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    FOLDER.mkdir(parents=True)
    write(FOLDER / "tall-1.tdms", 2000, laser=("V", [5, 4.5, np.nan, 4]))
    write(FOLDER / "tall 1.tdms", 1000, laser=("V", [5, 4]), load=("N", [1, 2]))
    write(FOLDER / "tall_2.tdms", 1000, upper=("V", [5, 4]), lower=("V", [1, 2]))
    write(FOLDER / "gauge.tdms", 500, angle=("deg", [0, 1]))
    (FOLDER / "broken.tdms").write_bytes(b"TDSm")
    (FOLDER / "notes.docx").write_bytes(b"")
    return FOLDER


def test_inspect_tells_channels_units_rates_ranges_and_the_checksum(folder, capsys):
    path = folder / "tall-1.tdms"
    assert cli.main(["inspect", str(path), "--no-plot"]) == 0
    assert capsys.readouterr().out == (
        f"{path}: TDMS, {path.stat().st_size} bytes\n"
        f"sha256 {sha256(path)}\n"
        "\n"
        "channel  unit  rate     duration  from  to  missing\n"
        "laser    V     2000 Hz  0.002 s   4     5   1\n"
    )
    assert not Path("results").exists()


def test_inspect_tells_what_the_reader_found_out_and_what_can_not_be_read(folder):
    table = "Zeit [s];Laser [V];Text;Last [N]\n" + "".join(
        f"{i / 100:.2f};{i};x;{i or 'NaN'}\n".replace(".", ",") for i in range(9)
    )
    (folder / "table.csv").write_text(table)
    text = look_text(look_into(folder / "table.csv"))
    assert text.count("columns between semicolons, decimal comma") == 1
    book = Workbook()
    rows = [["A1", None, "A2", None], ["t [s]", "a [deg]", "t [s]", "a [deg]"]]
    for row in rows + [[0.01 * i, i, 0.02 * i, i] if i < 8 else [0.01 * i, i] for i in range(12)]:
        book.active.append(row)
    book.save(folder / "pairs.xlsx")
    pairs = look_into(folder / "pairs.xlsx")
    assert [(channel.rate_hz, channel.n_samples) for channel in pairs.channels] == [
        (pytest.approx(100), 12),
        (pytest.approx(50), 8),
    ]


def test_inspect_of_what_can_not_be_read_fails_and_draws_nothing(folder, capsys):
    Path("bad.csv").write_text("time [s],laser [V]\n" + "0.1,1\n" * 120 + "0.2,abc\n" + "0.3,1\n" * 5)
    assert cli.main(["inspect", "bad.csv"]) == 1
    told = "laser: line 122, column 2: 'abc' is not a number; correct the line, or export the file again"
    assert capsys.readouterr() == ("", f"bad.csv: {told}\n")
    Path("bad.csv").write_text(",laser\n" + "".join(f"{i},{i % 3}\n" for i in range(9)))
    assert cli.main(["inspect", "bad.csv"]) == 1
    assert re.fullmatch("bad.csv: laser: .* sampling_rate_hz\n", capsys.readouterr().err)
    assert not Path("results").exists()


def test_a_new_campaign_tells_how_many_of_its_records_are_drawn(folder, capsys):
    for n in range(13):
        write(Path(f"{n}.tdms"), 10, laser=("V", [n, 0]))
    assert cli.main(["new-campaign", "long", "--from", "."]) == 0
    assert " 12 of 13 " in capsys.readouterr().out


def test_a_new_campaign_lists_proposes_and_marks_what_is_to_be_filled_in(folder, capsys):
    assert cli.main(["new-campaign", "lab", "--from", str(folder)]) == 0
    printed = capsys.readouterr()
    assert f"left out: {folder}/broken.tdms: " in printed.err
    assert "freerock check lab" in printed.out
    assert Path("results/lab/quick_look.png").stat().st_size > 0
    records = {path.name for path in folder.glob("*.tdms")} - {"broken.tdms"}
    assert {path.name for path in Path("raw/lab").iterdir()} == {*records, "manifest.csv"}
    assert listed_checksums("raw/lab") == {name: sha256(folder / name) for name in records}

    lines = Path("config/campaigns/lab.csv").read_text().splitlines()
    assert [line for line in lines[1:] if not line.startswith("#")] == [
        "gauge,gauge.tdms,,block1,foundation1,laser1,,,,",
        "tall_1,tall 1.tdms,laser,block1,foundation1,laser2,,,,",
        "tall_1_2,tall-1.tdms,,block1,foundation1,laser2,,,,",
        f"tall_2,tall_2.tdms,{FILL_IN},block1,foundation1,laser2,,,,",
    ]
    assert "# tall-1.tdms: laser (V, 2000 Hz, 0.0 s)" in lines
    assert any(line.startswith("# left out: ") and "broken.tdms" in line for line in lines)
    with pytest.raises(ConfigError) as caught:
        load_campaign("config/campaigns/lab.yaml")
    blanks = [str(problem) for problem in caught.value.problems]
    marked = Path("config/campaigns/lab.yaml").read_text().count(f": {FILL_IN}") + 1
    assert len(blanks) == marked
    assert all(": is still to be filled in; give " in blank for blank in blanks)


def test_a_channel_that_cannot_be_read_is_to_be_filled_in(folder):
    rows = [f"{i / 100},{i if i != 400 else 'lost'},{i}" for i in range(500)]
    for name, unit in (("heat.csv", "°C"), ("load.csv", "V")):
        (folder / name).write_text(f"time [s],laser [V],other [{unit}]\n" + "\n".join(rows) + "\n")
    assert cli.main(["new-campaign", "lab", "--from", str(folder)]) == 0
    cells = [line.split(",") for line in Path("config/campaigns/lab.csv").read_text().splitlines()]
    found = {row[1]: (row[2], row[5]) for row in cells if len(row) > 5 and not row[0].startswith("#")}
    assert found["heat.csv"] == (FILL_IN, FILL_IN)
    assert found["load.csv"] == (FILL_IN, "laser2")
    assert "laser3" not in Path("config/campaigns/lab.yaml").read_text()


def test_filled_in_it_is_sound(folder):
    assert cli.main(["new-campaign", "lab", "--from", str(folder)]) == 0
    values = {"title": "Tests", "origin": "measured", "height_m": "0.28", "width_m": "0.07"}
    values |= {"mass_kg": "5.8", "beam": "horizontal", "position_m": "0.2", "range_m": "0.1"}
    path = Path("config/campaigns/lab.yaml")
    path.write_text(re.sub(rf"(\w+): {FILL_IN}", lambda m: f"{m[1]}: {values[m[1]]}", path.read_text()))
    table = path.with_suffix(".csv")
    table.write_text(table.read_text().replace(FILL_IN, "upper"))
    assert cli.main(["check", "lab"]) == 0


@pytest.mark.parametrize("existing", ["config/campaigns/lab.yaml", "config/campaigns/lab.csv", "raw/lab/x"])
def test_nothing_is_overwritten(folder, existing, capsys):
    Path(existing).parent.mkdir(parents=True)
    Path(existing).write_text("mine")
    before = sorted(Path().rglob("*"))
    assert cli.main(["new-campaign", "lab", "--from", str(folder)]) == 1
    what = existing.removesuffix("/x")
    assert capsys.readouterr().err == (
        f"{what}: exists already; choose another name, or move it away first\n"
    )
    assert sorted(path for path in Path().rglob("*") if path.name != cli.LOG) == before


@pytest.mark.parametrize(
    ("name", "source", "line"),
    [
        ("my lab", "stick/day 1", "NAME: 'my lab' is not a name; use letters, digits and _ only"),
        ("studies", "stick/day 1", "studies: is a folder of results; choose another name"),
        ("lab", "nowhere", "nowhere: is no folder; name the folder of the record files"),
        ("lab", "stick", "stick: holds no record that can be read; put files of .tdms, .lvm, .csv, .tsv, "),
    ],
)
def test_what_can_not_begin_a_campaign(folder, name, source, line, capsys):
    assert cli.main(["new-campaign", name, "--from", source]) == 1
    assert capsys.readouterr().err.startswith(line)
    assert not Path("config").exists()
    assert not Path("raw").exists()
