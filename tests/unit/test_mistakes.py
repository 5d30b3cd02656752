"""Mistakes of a configuration: each is one line with its place and a remedy."""

from pathlib import Path

import pytest
from laboratory import CSV, HEADER, YAML, problems

from freerock.config.campaign import load_campaign, load_config
from freerock.config.mistakes import ConfigError


@pytest.fixture
def campaign(tmp_path, monkeypatch):
    """An empty folder, and the function that writes a campaign there and gives its problems."""
    monkeypatch.chdir(tmp_path)
    return problems


YAML_MISTAKES = [  # what is replaced, by what; place and remedy
    ("5.84", "1e-320", "lab.yaml:7: blocks.tall.mass_kg", "give 0, or 1e-12 to"),
    (
        "title: ",
        "processing: {impacts: {min_samples: true}}\ntitle: ",
        "lab.yaml:1: processing.impacts.min_samples",
        "give a number",
    ),
    (
        "range_m: 0.05",
        "range_m: 1,05",
        "lab.yaml:11: lasers.near.05",
        "write numbers with a decimal point",
    ),
    ("5.84", "-8.67", "lab.yaml:7: blocks.tall.mass_kg", "give the mass in kilograms"),
    ("5.84", "584000", "lab.yaml:7: blocks.tall.mass_kg", "give height_m and width_m in"),
    (
        "mass_kg: 5.84",
        "mass_kg: 5.84\n    contact_width_m: 0.08",
        "lab.yaml:8: blocks.tall.contact_width_m",
        "correct one of the two",
    ),
    (
        "mass_kg: 5.84",
        "mass_kg: 5.84\n    contact_width_m: 0.01\n    release_angle_deg: 10",
        "lab.yaml:9: blocks.tall.release_angle_deg",
        "correct the release angle, the",
    ),
    (
        "title",
        "fits: {kinematics: [pivotting]}\ntitle",
        "lab.yaml:1: fits.kinematics.0",
        "did you mean 'pivoting'?",
    ),
    (
        "title",
        "fits: {kinematics: []}\ntitle",
        "lab.yaml:1: fits.kinematics",
        "give the kinematics of rivals:",
    ),
    (
        "title: ",
        "fits: {free: {winkler: [t0, theta0, theta0]}}\ntitle: ",
        "lab.yaml:1: fits.free.winkler",
        "keep one",
    ),
    (
        "marble: {}",
        "tall: {label: Steel plate}\n  marble: {}",
        "lab.yaml:8: foundations",
        "rename one of the two",
    ),
    (
        "foundations",
        "  old: {height_m: 1, width_m: 0.5, mass_kg: 1, label: tall}\nfoundations",
        "lab.yaml:3: blocks",
        "give each its own label",
    ),
    ("title", "titel", "lab.yaml:1: titel", "did you mean 'title'?"),
    ("mass_kg", "mass", "lab.yaml:7: blocks.tall.mass", "did you mean 'mass_kg'?"),
    ("    width_m: 0.07\n", "", "lab.yaml:4: blocks.tall.width_m", "give the full width 2b"),
    ("0.28", "0,28", "lab.yaml:5: blocks.tall.height_m", "give the full height 2h"),
    ("5.84", ".nan", "lab.yaml:7: blocks.tall.mass_kg", "give the mass in kilograms"),
    ("5.84", "", "lab.yaml:7: blocks.tall.mass_kg", "give the mass in kilograms"),
    (
        "  tall:\n    height_m: 0.28\n    width_m: 0.07\n    mass_kg: 5.84\n",
        "",
        "lab.yaml:3: blocks",
        "give one or more blocks",
    ),
    ("5.84", "{kg: 5.84}", "lab.yaml:7: blocks.tall.mass_kg", "give the mass in kilograms"),
    ("{}", "stone", "lab.yaml:9: foundations.marble", "give one or more foundations"),
    ("{}", "{}\n  ../mat: {}", "lab.yaml:10: foundations.../mat", "use letters, digits and _"),
    ("horizontal", "horizontl", "lab.yaml:11: lasers.near.beam", "did you mean 'horizontal'?"),
    ("0.1,", "-0.1,", "lab.yaml:11: lasers.near.position_m", "give the height of the"),
    ("beam: horizontal, ", "", "lab.yaml:11: lasers.near.beam", "give horizontal (meets a side"),
    (
        "position_m: 0.1, range_m: 0.05",
        "units: deg",
        "lab.yaml:11: lasers.near.beam",
        "remove it, or correct units",
    ),
    ("0.05}", "0.05, units: kg}", "lab.yaml:11: lasers.near.units", "by default as the file"),
    (
        "0.05}",
        "0.05, sensitivity_per_mm: 0.2}",
        "lab.yaml:11: lasers.near.sensitivity_per_mm",
        "keep one of the two",
    ),
    (
        "0.05}",
        "0.05, volts_at_start: 10, volts_at_end: 0}",
        "lab.yaml:11: lasers.near.volts_at_end",
        "swap the two and set",
    ),
    ("5.84", "FILL_IN", "lab.yaml:7: blocks.tall.mass_kg", "give the mass in kilograms"),
    (
        "title",
        "plan: {expected: {marble: {housner: {r: 1}}}, sensors: {a: {noise_v: 1, noise_m: 1}}}\ntitle",
        "lab.yaml:1: plan.sensors.a",
        "give one of noise_v, noise_m",
    ),
    (
        "title",
        "plan: {expected: {marble: {winkler: {k: 1}}}, sensors: {a: {noise_v: 1}}}\ntitle",
        "lab.yaml:1: plan.expected",
        "give c or leave winkler",
    ),
    (
        "range_m: 0.05",
        "calibration: ../t.csv",
        "lab.yaml:11: lasers.near.calibration",
        "give a path below it",
    ),
    (
        "title",
        "fits: {models: [housner, hunt_crosley]}\ntitle",
        "lab.yaml:1: fits.models.1",
        "did you mean 'hunt_crossley'?",
    ),
    (
        "title",
        "published: {doi: 10.1000/x, values: {tal: {marble: {housner: {r: 0.9}}}}}\ntitle",
        "lab.yaml:1: published",
        "did you mean 'tall'?",
    ),
    (
        "    mass_kg: 5.84",
        "    mass_kg: 5.84\n    mass_kg: 5.9",
        "lab.yaml:8: blocks.tall.mass_kg",
        "keep one",
    ),
    ("    width_m", "\twidth_m", "lab.yaml:6", "indent with spaces, not tabs"),
    ("{}", "{", "lab.yaml:9", "close the brace"),
    ("Blocks", "!!python/object/apply:os.getcwd []", "lab.yaml:1", "correct the YAML"),
    ("position_m: 0.1", "position_m: 100", "lab.csv:2: laser", "give the beam's height above"),
    (YAML, "", "lab.yaml", "write lines of the form"),
    (YAML, "- tall\n", "lab.yaml", "write lines of the form"),
]
CSV_MISTAKES = [
    ("tall", "tal", "lab.csv:2: block", "did you mean 'tall'?"),
    (",,tall,marble,near", ",top;low,tall,marble,near;neer", "lab.csv:2: laser", "did you mean 'near'?"),
    (",,tall,marble,near", ",u; u,tall,marble,near;near", "lab.csv:2: laser", "name a channel for each"),
    (",,tall,marble,near", ",top;low,tall,marble,near;near", "lab.csv:2: laser", "give both positions"),
    ("a.tdms,,", "a.tdms,FILL_IN,", "lab.csv:2: channel", "empty if the file has"),
    ("a,a.tdms", "../a,a.tdms", "lab.csv:2: test", "use letters, digits and _"),
    ("a.tdms", "../a.tdms", "lab.csv:2: file", "give a path below it"),
    ("a.tdms", "", "lab.csv:2: file", "give the record file, inside"),
    (
        "near,,,,\n",
        "near,,,,\nA,b.tdms,,tall,marble,near,,,,\n",
        "lab.csv:3: test",
        "give each record its own",
    ),
    ("near,,,,", "near,2;3,,,", "lab.csv:2: reason", "say why"),
    ("near,,,,", "near,second,,bad,", "lab.csv:2: exclude", "give record, or numbers of"),
    ("near,,,,", "near,,12.3:19.8,bad,", "lab.csv:2: override", "give run and seconds, as"),
    ("near,,,,", "near,,1@19.8:12.3,bad,", "lab.csv:2: override", "give the release first"),
    ("near,,,,", "near,,1@1:2;1@3:4,bad,", "lab.csv:2: override", "give each run once"),
    ("near,,,,", "near,,1@3:4 hold 2:3.5,bad,", "lab.csv:2: override", "end the hold before"),
    ("near,,,,", "near,,1@1:3.5;2@3:4,bad,", "lab.csv:2: override", "end it before"),
    ("foundation,", "fundation,", "lab.csv:1: fundation", "did you mean 'foundation'?"),
    (CSV, "test,file,block,foundation\na,a.tdms,tall,marble\n", "lab.csv:1: laser", "add it: the name of"),
    ("near,,,,", "near,,,,wet, cold", "lab.csv:2", "put texts that hold a"),
    (CSV, CSV.replace(",", ";"), "lab.csv:1", "separated by commas"),
    (
        CSV,
        HEADER,
        "lab.csv",
        "and a line per record",
    ),
    ("near,,,,", 'near,,,,"wet', "lab.csv:2", "check the quotes"),
]


@pytest.mark.parametrize(("old", "new", "place", "remedy"), YAML_MISTAKES)
def test_mistake_in_yaml_is_one_line(campaign, old, new, place, remedy):
    (line,) = campaign(yaml_change=(old, new))
    assert line.startswith(f"{place}: ") and remedy in line, line


@pytest.mark.parametrize(("old", "new", "place", "remedy"), CSV_MISTAKES)
def test_mistake_in_csv_is_one_line(campaign, old, new, place, remedy):
    (line,) = campaign(csv_change=(old, new))
    assert line.startswith(f"{place}: ") and remedy in line, line


def test_all_mistakes_of_all_files_are_reported_at_once(campaign):
    lines = campaign(yaml_change=("_m: 0.", "_m: -0."), csv_change=("a,a.tdms,,tall", "a b,,,tal"))
    assert [line.split(": ")[:2] for line in lines] == [
        ["lab.yaml:5", "blocks.tall.height_m"],
        ["lab.yaml:6", "blocks.tall.width_m"],
        ["lab.yaml:11", "lasers.near.position_m"],
        ["lab.yaml:11", "lasers.near.range_m"],
        ["lab.csv:2", "test"],
        ["lab.csv:2", "file"],
        ["lab.csv:2", "block"],
    ]


@pytest.mark.parametrize(
    "other",
    ["beam: vertical, position_m: 0.02", "beam: horizontal, position_m: 0.2, face: right", "units: deg"],
)
def test_two_lasers_whose_beams_differ_are_refused(campaign, other):
    lines = campaign(
        yaml_change=("lasers:", f"lasers:\n  far: {{{other}}}"),
        csv_change=(",,tall,marble,near", ",top;low,tall,marble,far; near"),
    )
    assert lines == [
        "lab.csv:2: laser: the two beams differ in kind or in face; use two of one kind, on one face"
    ]


def test_a_file_that_is_not_utf8_is_reported_with_its_line(campaign):
    campaign(csv_change=("near", "far"))
    Path("config/campaigns/lab.csv").write_bytes(CSV.replace(",\n", ",Ä\n").encode("latin-1"))
    with pytest.raises(ConfigError, match=r"lab\.csv:2: is not UTF-8 text; save the file as UTF-8"):
        load_campaign("config/campaigns/lab.yaml")


def test_missing_campaign_is_reported_with_the_nearest_name(campaign):
    campaign(csv_change=("near", "far"))
    Path("config/config.yaml").write_text("campaigns: [lap]\n")
    with pytest.raises(ConfigError) as caught:
        load_config("config/config.yaml")
    assert str(caught.value) == (
        "config/config.yaml:1: campaigns: there is no campaign 'lap': config/campaigns/lap.yaml is missing; "
        "did you mean 'lab'?"
    )


def test_missing_files_are_reported(campaign):
    campaign(csv_change=("near", "far"))
    Path("config/campaigns/lab.csv").unlink()
    Path("config/config.yaml").write_text("campaigns: [lab]\n")
    with pytest.raises(
        ConfigError, match=r"^config/campaigns/lab\.csv: is missing; .*test,file,channel,block"
    ):
        load_config("config/config.yaml")
    with pytest.raises(ConfigError, match=r"^nowhere\.yaml: cannot be read \(No such file"):
        load_config("nowhere.yaml")
