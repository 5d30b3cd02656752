"""The line for each mistake of a configuration."""

from pathlib import Path

import pytest
from laboratory import CSV, HEADER, QUOTED_LAWS, YAML, problems

from freerock.config.campaign import load_campaign, load_config
from freerock.config.hand_corrections import EXCLUDED
from freerock.config.keys_of_fits import FitsSection
from freerock.config.mistakes import ConfigError


@pytest.fixture
def campaign(tmp_path, monkeypatch):
    """An empty folder, and the function that writes a campaign there and gives its problems."""
    monkeypatch.chdir(tmp_path)
    return problems


NO_OVERRIDE = (
    "is not run@release:end, nor run@release:end hold from:to; "
    "give run and seconds, as 2@12.310:19.800 or 2@12.310:19.800 hold 10.000:12.200"
)
YAML_MISTAKES = {
    "a mass that no double's powers hold": (
        ("5.84", "1e-320"),
        "lab.yaml:7: blocks.tall.mass_kg: 9.99989e-321 is out of range; give 0, or 1e-12 to 1e+15",
    ),
    "a beam beyond the laboratory": (
        ("position_m: 0.1", "position_m: 1e308"),
        "lab.yaml:11: lasers.near.position_m: 1e+308 is out of range; give 0, or 1e-12 to 1e+15",
    ),
    "a stiffness beyond any ground": (
        (
            "title",
            "plan: {expected: {marble: {winkler: {k: 1e308, c: 1}}}, sensors: {a: {noise_v: 1}}}\ntitle",
        ),
        "lab.yaml:1: plan.expected.marble.winkler.k: 1e+308 is out of range; give 0, or 1e-12 to 1e+15",
    ),
    "a switch for a number": (
        ("title: ", "records_per_job: true\ntitle: "),
        "lab.yaml:1: records_per_job: true is not a number; give a number",
    ),
    "a switch for a direction": (
        ("position_m: 0.1", "sign: true, position_m: 0.1"),
        "lab.yaml:11: lasers.near.sign: true is not a number; give a number",
    ),
    "negative mass": (
        ("5.84", "-8.67"),
        "lab.yaml:7: blocks.tall.mass_kg: -8.67 is not greater than 0; give the mass in kilograms",
    ),
    "a mass in grams": (
        ("5.84", "584000"),
        "lab.yaml:7: blocks.tall.mass_kg: as deep as it is high, the block would have 1.06e+08 kg/m³; "
        "give height_m and width_m in metres, mass_kg in kilograms",
    ),
    "wide corners": (
        ("mass_kg: 5.84", "mass_kg: 5.84\n    contact_width_m: 0.08"),
        "lab.yaml:8: blocks.tall.contact_width_m: 0.08 is more than the full width; correct one of the two",
    ),
    "worn and released too far": (
        ("mass_kg: 5.84", "mass_kg: 5.84\n    contact_width_m: 0.01\n    release_angle_deg: 10"),
        "lab.yaml:9: blocks.tall.release_angle_deg: released at 10° the block overturns, its critical "
        "angle is 2.045°; correct the release angle, the height or the width",
    ),
    "a joint fit": (
        ("title: ", "fits: {pooled: true}\ntitle: "),
        "lab.yaml:1: fits.pooled: runs are no longer fitted jointly; "
        "remove it: tables give the mean of the runs",
    ),
    "unknown kinematics": (
        ("title", "fits: {kinematics: [pivotting]}\ntitle"),
        "lab.yaml:1: fits.kinematics.0: 'pivotting' is not 'guided' or 'pivoting'; did you mean 'pivoting'?",
    ),
    "no kinematics": (
        ("title", "fits: {kinematics: []}\ntitle"),
        f"lab.yaml:1: fits.kinematics: is empty; give {FitsSection.model_fields['kinematics'].description}",
    ),
    "kinematics twice": (
        ("title", "fits: {kinematics: [guided, guided]}\ntitle"),
        "lab.yaml:1: fits.kinematics: guided is given twice; keep one",
    ),
    "freed twice": (
        ("title: ", "fits: {free: {winkler: [t0, theta0, theta0]}}\ntitle: "),
        "lab.yaml:1: fits.free.winkler: theta0 is given twice; keep one",
    ),
    "a foundation named as a block": (
        ("marble: {}", "tall: {label: Steel plate}\n  marble: {}"),
        "lab.yaml:8: foundations: 'tall' is the name of a block already; rename one of the two",
    ),
    "two blocks of one label": (
        ("foundations", "  old: {height_m: 1, width_m: 0.5, mass_kg: 1, label: tall}\nfoundations"),
        "lab.yaml:3: blocks: 'tall' and 'old' are both printed as 'tall'; give each its own label",
    ),
    "two foundations of one label": (
        ("marble: {}", "marble: {label: Stone}\n  granite: {label: Stone}"),
        "lab.yaml:8: foundations: 'marble' and 'granite' are both printed as 'Stone'; "
        "give each its own label",
    ),
    "unknown key": (("title", "titel"), "lab.yaml:1: titel: unknown key; did you mean 'title'?"),
    "renamed key": (
        ("mass_kg", "mass"),
        "lab.yaml:7: blocks.tall.mass: unknown key; did you mean 'mass_kg'?",
    ),
    "foreign key": (
        ("mass_kg: 5.84", "mass_kg: 5.84\n    zebra: 1"),
        "lab.yaml:8: blocks.tall.zebra: unknown key; "
        "use one of height_m, width_m, mass_kg, contact_width_m, com_height_m, com_offset_m, inertia_kg_m2, "
        "gravity_m_s2, release_angle_deg, label, uncertainty",
    ),
    "missing key": (
        ("    width_m: 0.07\n", ""),
        "lab.yaml:4: blocks.tall.width_m: is missing; "
        "give the full width 2b in the plane of rocking in metres",
    ),
    "decimal comma": (
        ("0.28", "0,28"),
        "lab.yaml:5: blocks.tall.height_m: '0,28' is not a valid number; give the full height 2h in metres",
    ),
    "decimal comma in braces": (
        ("0.05}", "0,05}"),
        "lab.yaml:11: lasers.near.range_m: 0,05 has a decimal comma; write 0.05",
    ),
    "switch for a number": (
        ("0.28", "true"),
        "lab.yaml:5: blocks.tall.height_m: true is not a number; give a number",
    ),
    "not finite": (
        ("5.84", ".nan"),
        "lab.yaml:7: blocks.tall.mass_kg: nan is not a finite number; give the mass in kilograms",
    ),
    "empty value": (
        ("5.84", ""),
        "lab.yaml:7: blocks.tall.mass_kg: is empty; give the mass in kilograms",
    ),
    "no block": (
        ("  tall:\n    height_m: 0.28\n    width_m: 0.07\n    mass_kg: 5.84\n", ""),
        "lab.yaml:3: blocks: is empty; give one or more blocks, each by its name",
    ),
    "group for a value": (
        ("5.84", "{kg: 5.84}"),
        "lab.yaml:7: blocks.tall.mass_kg: a group of keys does not belong here; give the mass in kilograms",
    ),
    "value for a group": (
        ("{}", "stone"),
        "lab.yaml:9: foundations.marble: 'stone' is not a group of keys; "
        "give one or more foundations, each by its name",
    ),
    "list for a group": (
        ("{}", "[stone]"),
        "lab.yaml:9: foundations.marble: a list does not belong here; "
        "give one or more foundations, each by its name",
    ),
    "name with a slash": (
        ("{}", "{}\n  ../mat: {}"),
        "lab.yaml:10: foundations.../mat: '../mat' is not a name; use letters, digits and _ only",
    ),
    "number for a text": (
        ("Blocks", "2017"),
        "lab.yaml:1: title: 2017 is not a valid string; give the title of the campaign, in quotes",
    ),
    "word close to a choice": (
        ("horizontal", "horizontl"),
        "lab.yaml:11: lasers.near.beam: 'horizontl' is not 'horizontal' or 'vertical'; "
        "did you mean 'horizontal'?",
    ),
    "word far from a choice": (
        ("measured", "real"),
        "lab.yaml:2: origin: 'real' is not 'simulated' or 'measured'; "
        "give simulated or measured, as shown in every dataset, table and figure",
    ),
    "beam below the base": (
        ("0.1,", "-0.1,"),
        "lab.yaml:11: lasers.near.position_m: -0.1 is not above the base; "
        "give the height of the beam in metres",
    ),
    "no beam": (
        ("beam: horizontal, ", ""),
        "lab.yaml:11: lasers.near.beam: is missing; give horizontal (meets a side face) or vertical "
        "(meets the top), or declare units: deg where the channel is the rotation",
    ),
    "beam of a rotation": (
        ("position_m: 0.1, range_m: 0.05", "units: deg"),
        "lab.yaml:11: lasers.near.beam: a channel in deg is the rotation itself; remove it, or correct units",
    ),
    "position of a rotation": (
        ("beam: horizontal, position_m: 0.1, range_m: 0.05", "position_m: 0.1, units: mrad"),
        "lab.yaml:11: lasers.near.position_m: a channel in mrad is the rotation itself; "
        "remove it, or correct units",
    ),
    "unit of no channel": (
        ("0.05}", "0.05, units: kg}"),
        "lab.yaml:11: lasers.near.units: 'kg' is not '', 'V', 'mV', 'kV', 'mA', 'A', 'm', 'cm', 'mm', "
        "'um', 'rad', 'mrad' or 'deg'; give the unit of the channel: of the output, the displacement or "
        "the rotation; by default as the file states it",
    ),
    "unit of no channel, and no beam": (
        ("beam: horizontal, position_m: 0.1, range_m: 0.05", "units: degree"),
        "lab.yaml:11: lasers.near.units: 'degree' is not '', 'V', 'mV', 'kV', 'mA', 'A', 'm', 'cm', 'mm', "
        "'um', 'rad', 'mrad' or 'deg'; did you mean 'deg'?",
    ),
    "two scales": (
        ("0.05}", "0.05, sensitivity_per_mm: 0.2}"),
        "lab.yaml:11: lasers.near.sensitivity_per_mm: range_m scales the output already; keep one of the two",
    ),
    "falling current": (
        ("0.05}", "0.05, milliamps_at_end: 4}"),
        "lab.yaml:11: lasers.near.milliamps_at_end: 4 is not above milliamps_at_start; "
        "swap the two and set sign: -1",
    ),
    "volts that start above the usual end": (
        ("0.05}", "0.05, volts_at_start: 12}"),
        "lab.yaml:11: lasers.near.volts_at_end: 10 is not above volts_at_start; "
        "swap the two and set sign: -1",
    ),
    "current that starts above the usual end": (
        ("0.05}", "0.05, milliamps_at_start: 20}"),
        "lab.yaml:11: lasers.near.milliamps_at_end: 20 is not above milliamps_at_start; "
        "swap the two and set sign: -1",
    ),
    "falling output": (
        ("0.05}", "0.05, volts_at_start: 10, volts_at_end: 0}"),
        "lab.yaml:11: lasers.near.volts_at_end: 0 is not above volts_at_start; swap the two and set sign: -1",
    ),
    "a value left to fill in": (
        ("5.84", "FILL_IN"),
        "lab.yaml:7: blocks.tall.mass_kg: is still to be filled in; give the mass in kilograms",
    ),
    "a text left to fill in": (
        ("Blocks", "FILL_IN"),
        "lab.yaml:1: title: is still to be filled in; give the title of the campaign",
    ),
    "two noises": (
        (
            "title",
            "plan: {expected: {marble: {housner: {r: 1}}}, sensors: {a: {noise_v: 1, noise_m: 1}}}\ntitle",
        ),
        "lab.yaml:1: plan.sensors.a: has noise_v and noise_m; give one of noise_v, noise_m, noise_deg",
    ),
    "a plan of an incomplete model": (
        ("title", "plan: {expected: {marble: {winkler: {k: 1}}}, sensors: {a: {noise_v: 1}}}\ntitle"),
        "lab.yaml:1: plan.expected: winkler on marble has no c; give c or leave winkler out",
    ),
    "a plan of a restitution above 1": (
        ("title", "plan: {expected: {marble: {housner: {r: 2}}}, sensors: {a: {noise_v: 1}}}\ntitle"),
        "lab.yaml:1: plan.expected: r = 2 on marble is above 1; give r up to 1",
    ),
    "no DOI": (
        ("title", "published: {doi: spanos, values: {}}\ntitle"),
        "lab.yaml:1: published.doi: 'spanos' is not understood; give the DOI of the publication, as 10.…/…",
    ),
    "calibration outside": (
        ("range_m: 0.05", "calibration: ../t.csv"),
        "lab.yaml:11: lasers.near.calibration: '../t.csv' is not inside the raw folder; "
        "give a path below it, with / between folders",
    ),
    "released beyond the critical angle": (
        ("5.84", "5.84\n    release_angle_deg: 15"),
        "lab.yaml:8: blocks.tall.release_angle_deg: released at 15° the block overturns, "
        "its critical angle is 14.036°; correct the release angle, the height or the width",
    ),
    "truth of a measurement": (
        ("measured", "measured\ntruth: truth.json"),
        "lab.yaml:3: truth: a measured campaign has no known truth; remove the key or set origin: simulated",
    ),
    "truth outside": (
        ("measured", "simulated\ntruth: ../truth.json"),
        "lab.yaml:3: truth: '../truth.json' is not inside the raw folder; "
        "give a path below it, with / between folders",
    ),
    "unknown model": (
        ("title", "fits: {models: [housner, hunt_crosley]}\ntitle"),
        f"lab.yaml:1: fits.models.1: 'hunt_crosley' is not {QUOTED_LAWS}; did you mean 'hunt_crossley'?",
    ),
    "candidate for a law": (
        ("title", "fits: {models: [hunt_crossley_pivoting]}\ntitle"),
        f"lab.yaml:1: fits.models.0: 'hunt_crossley_pivoting' is not {QUOTED_LAWS}; "
        "did you mean 'hunt_crossley'?",
    ),
    "text for a list": (
        ("title", "fits: {models: housner}\ntitle"),
        "lab.yaml:1: fits.models: 'housner' is not a list; "
        f"give {FitsSection.model_fields['models'].description}",
    ),
    "published for an unknown block": (
        ("title", "published: {doi: 10.1000/x, values: {tal: {marble: {housner: {r: 0.9}}}}}\ntitle"),
        "lab.yaml:1: published: 'tal' is not a block of this campaign; did you mean 'tall'?",
    ),
    "published parameter of another model": (
        ("title", "published: {doi: 10.1000/x, values: {tall: {marble: {housner: {k: 1}}}}}\ntitle"),
        "lab.yaml:1: published.values: 'k' is not a parameter of housner; use one of r, epsilon_theta",
    ),
    "key given twice": (
        ("    mass_kg: 5.84", "    mass_kg: 5.84\n    mass_kg: 5.9"),
        "lab.yaml:8: blocks.tall.mass_kg: is given twice, first on line 7; keep one",
    ),
    "tab": (
        ("    width_m", "\twidth_m"),
        "lab.yaml:6: found character '\\t' that cannot start any token; "
        "correct the YAML; indent with spaces, not tabs",
    ),
    "open bracket": (
        ("{}", "{"),
        "lab.yaml:11: expected ',' or '}', but got ':'; correct the YAML; indent with spaces, not tabs",
    ),
    "python object": (
        ("Blocks", "!!python/object/apply:os.getcwd []"),
        "lab.yaml:1: the tag 'tag:yaml.org,2002:python/object/apply:os' has no meaning here; "
        "give the value alone, in quotes where it is a text",
    ),
    "a name too long for a file": (
        ("marble: {}", f"marble: {{}}\n  {'t' * 245}: {{}}"),
        f"lab.yaml:10: foundations.{'t' * 245}: '{'t' * 49}…' has 245 characters; use 100 at most",
    ),
    "a label too long for a figure": (
        ("mass_kg: 5.84", f"mass_kg: 5.84\n    label: {'T' * 300}"),
        f"lab.yaml:8: blocks.tall.label: '{'T' * 49}…' has 300 characters; use 100 at most",
    ),
    "a sign for the terminal in a label": (
        ("mass_kg: 5.84", 'mass_kg: 5.84\n    label: "T\\e[31m"'),
        r"lab.yaml:8: blocks.tall.label: has the character '\x1b'; leave it out",
    ),
    "half a character in a label": (
        ("mass_kg: 5.84", 'mass_kg: 5.84\n    label: "T\\ud800"'),
        r"lab.yaml:8: blocks.tall.label: has the character '\ud800'; leave it out",
    ),
    "a pattern for a folder": (
        ("title", "raw: raw/{x}\ntitle"),
        "lab.yaml:1: raw: 'raw/{x}' has braces, which Snakemake takes for wildcards; rename it",
    ),
    "minutes of YAML 1.1": (
        ("0.28", "1:30"),
        "lab.yaml:5: blocks.tall.height_m: '1:30' is not a valid number; give the full height 2h in metres",
    ),
    "a word for a number": (
        ("0.28", "yes"),
        "lab.yaml:5: blocks.tall.height_m: 'yes' is not a valid number; give the full height 2h in metres",
    ),
    "thousands": (
        ("5.84", "5_840"),
        "lab.yaml:7: '5_840' is not a number; write it shorter, without _",
    ),
    "version of YAML": (
        ("title", "%YAML 1.1\n---\ntitle"),
        "lab.yaml:1: begins with %; leave the line out",
    ),
    "beam above the block": (
        ("position_m: 0.1", "position_m: 100"),
        "lab.csv:2: laser: position_m of near is 100: above the block tall, 0.28 m high; "
        "give the beam's height above the base in metres, or correct height_m",
    ),
    "empty file": ((YAML, ""), "lab.yaml: is empty; write lines of the form key: value"),
    "not keys and values": (
        (YAML, "- tall\n"),
        "lab.yaml: is not a list of keys and values; write lines of the form key: value",
    ),
}


@pytest.mark.parametrize("mistake", YAML_MISTAKES)
def test_mistake_in_yaml_is_reported_in_one_line(campaign, mistake):
    change, line = YAML_MISTAKES[mistake]
    assert campaign(yaml_change=change) == [line]


CSV_MISTAKES = {
    "unknown block": (
        ("tall", "tal"),
        "lab.csv:2: block: 'tal' is not a block of lab.yaml; did you mean 'tall'?",
    ),
    "unknown laser": (
        ("near", "x1"),
        "lab.csv:2: laser: 'x1' is not a laser of lab.yaml; use one of near",
    ),
    "unknown second laser": (
        (",,tall,marble,near", ",top;low,tall,marble,near;neer"),
        "lab.csv:2: laser: 'neer' is not a laser of lab.yaml; did you mean 'near'?",
    ),
    "one channel for two lasers": (
        ("near", "near;near"),
        "lab.csv:2: laser: 2 for 1 channels; name a channel for each, as a;b in both columns",
    ),
    "one channel for both lasers": (
        (",,tall,marble,near", ",u; u,tall,marble,near;near"),
        "lab.csv:2: laser: both are given channel 'u'; name a channel for each, as a;b in both columns",
    ),
    "one laser twice": (
        (",,tall,marble,near", ",top;low,tall,marble,near;near"),
        "lab.csv:2: laser: the two beams are at one position_m; give both positions",
    ),
    "channel left to fill in": (
        ("a.tdms,,", "a.tdms,FILL_IN,"),
        "lab.csv:2: channel: is still to be filled in; give the channel of the laser, or of two lasers as "
        "a;b; empty if the file has only one",
    ),
    "block left to fill in": (
        ("tall", "FILL_IN"),
        "lab.csv:2: block: is still to be filled in; give the name of a block",
    ),
    "more than two lasers": (
        (",,tall,marble,near", ",a;b;c,tall,marble,near;near;near"),
        "lab.csv:2: laser: 'near;near;near' names more than two lasers; name one or two",
    ),
    "test name": (
        ("a,a.tdms", "../a,a.tdms"),
        "lab.csv:2: test: '../a' is not a name; use letters, digits and _ only",
    ),
    "file outside": (
        ("a.tdms", "../a.tdms"),
        "lab.csv:2: file: '../a.tdms' is not inside the raw folder; "
        "give a path below it, with / between folders",
    ),
    "absolute file": (
        ("a.tdms", "/data/a.tdms"),
        "lab.csv:2: file: '/data/a.tdms' is not inside the raw folder; "
        "give a path below it, with / between folders",
    ),
    "backslash": (
        ("a.tdms", "day1\\a.tdms"),
        "lab.csv:2: file: 'day1\\\\a.tdms' is not inside the raw folder; "
        "give a path below it, with / between folders",
    ),
    "no file": (
        ("a.tdms", ""),
        "lab.csv:2: file: is empty; give the record file, inside the raw folder",
    ),
    "no test name": (
        ("a,a.tdms", ",a.tdms"),
        "lab.csv:2: test: is empty; give the name of the record: letters, digits and _",
    ),
    "same test twice": (
        ("near,,,,\n", "near,,,,\nA,b.tdms,,tall,marble,near,,,,\n"),
        "lab.csv:3: test: 'A' is on line 2 already; give each record its own name",
    ),
    "exclude without reason": (
        ("near,,,,", "near,2;3,,,"),
        "lab.csv:2: reason: exclude or override is given without a reason; say why",
    ),
    "override without reason": (
        ("near,,,,", "near,,2@1:9,,"),
        "lab.csv:2: reason: exclude or override is given without a reason; say why",
    ),
    "exclude in words": (
        ("near,,,,", "near,second,,bad,"),
        f"lab.csv:2: exclude: 'second' is not understood; give {EXCLUDED}",
    ),
    "exclude of 5000 digits": (
        ("near,,,,", f"near,{'9' * 5000},,bad,"),
        f"lab.csv:2: exclude: '{'9' * 49}…' is not understood; give {EXCLUDED}",
    ),
    "exclude a stretch that ends before it begins": (
        ("near,,,,", "near,3.5:3.2,,bad,"),
        "lab.csv:2: exclude: the stretch 3.5:3.2 ends before it begins; give its begin first",
    ),
    "override of 5000 digits": (
        ("near,,,,", f"near,,{'9' * 5000}@1:2,bad,"),
        f"lab.csv:2: override: '{'9' * 49}…' {NO_OVERRIDE}",
    ),
    "a test too long for a file": (
        ("a,a.tdms", f"{'a' * 300},a.tdms"),
        f"lab.csv:2: test: '{'a' * 49}…' has 300 characters; use 100 at most",
    ),
    "a file name too long": (
        ("a,a.tdms", f"a,{'a' * 300}.tdms"),
        f"lab.csv:2: file: '{'a' * 49}…' is longer than a file name may be; rename the file",
    ),
    "override without run": (
        ("near,,,,", "near,,12.3:19.8,bad,"),
        f"lab.csv:2: override: '12.3:19.8' {NO_OVERRIDE}",
    ),
    "override backwards": (
        ("near,,,,", "near,,1@19.8:12.3,bad,"),
        "lab.csv:2: override: run 1 ends before it is released; give the release first",
    ),
    "override twice": (
        ("near,,,,", "near,,1@1:2;1@3:4,bad,"),
        "lab.csv:2: override: a run is overridden twice; give each run once",
    ),
    "override of run 0": (
        ("near,,,,", "near,,0@1:2,bad,"),
        "lab.csv:2: override: there is no run 0; count from 1",
    ),
    "hold by hand that is no window": (
        ("near,,,,", "near,,1@3:4 hold 2,bad,"),
        f"lab.csv:2: override: '1@3:4 hold 2' {NO_OVERRIDE}",
    ),
    "hold by hand backwards": (
        ("near,,,,", "near,,1@3:4 hold 2:1,bad,"),
        "lab.csv:2: override: the hold of run 1 ends before it begins; give its begin first",
    ),
    "hold by hand after the release": (
        ("near,,,,", "near,,1@3:4 hold 2:3.5,bad,"),
        "lab.csv:2: override: run 1 is held until 3.5 s and released at 3 s; end the hold before the release",
    ),
    "overrides against the order of release": (
        ("near,,,,", "near,,2@1:2;1@3:4,bad,"),
        "lab.csv:2: override: run 1 is released at 3 s, run 2 at 1 s; number runs in the order of release",
    ),
    "overrides that overlap": (
        ("near,,,,", "near,,1@1:3.5;2@3:4,bad,"),
        "lab.csv:2: override: run 1 ends at 3.5 s, run 2 is released at 3 s; end it before",
    ),
    "hold by hand within the run before": (
        ("near,,,,", "near,,1@1:3;3@4:5 hold 2:3.9,bad,"),
        "lab.csv:2: override: run 1 ends at 3 s, run 3 is held from 2 s; begin the hold later",
    ),
    "unknown column": (
        ("foundation,", "fundation,"),
        "lab.csv:1: fundation: unknown column; did you mean 'foundation'?",
    ),
    "column of another name": (
        ("note\n", "colour\n"),
        "lab.csv:1: colour: unknown column; use test, file, channel, block, foundation, laser, exclude, "
        "override, reason, note",
    ),
    "missing column": (
        (CSV, "test,file,block,foundation\na,a.tdms,tall,marble\n"),
        "lab.csv:1: laser: column is missing; add it: the name of a laser, or of two lasers as a;b",
    ),
    "column twice": (("note\n", "test\n"), "lab.csv:1: test: column given twice; keep one"),
    "too many cells": (
        ("near,,,,", "near,,,,wet, cold"),
        "lab.csv:2: has 11 cells, the first line has 10; put texts that hold a comma in quotes",
    ),
    "no line of columns": (
        (HEADER, ""),
        "lab.csv:1: names no columns; begin with a line of their names, those in use: "
        "test,file,channel,block,foundation,laser,exclude,override,reason,note",
    ),
    "semicolons": (
        (CSV, CSV.replace(",", ";")),
        "lab.csv:1: has no commas; separate the columns by commas",
    ),
    "no record": (
        (CSV, HEADER),
        "lab.csv: has no record; write the line "
        "test,file,channel,block,foundation,laser,exclude,override,reason,note "
        "and a line per record",
    ),
    "open quote": (
        ("near,,,,", 'near,,,,"wet'),
        "lab.csv:2: a quote is not closed; check the quotes",
    ),
}


@pytest.mark.parametrize("mistake", CSV_MISTAKES)
def test_mistake_in_csv_is_reported_in_one_line(campaign, mistake):
    change, line = CSV_MISTAKES[mistake]
    assert campaign(csv_change=change) == [line]


def test_there_are_mistakes_of_many_kinds():
    assert (
        len({line.split(": ", 1)[1] for _, line in (*YAML_MISTAKES.values(), *CSV_MISTAKES.values())}) >= 40
    )


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
    with pytest.raises(ConfigError, match=r"^config/campaigns/lab\.csv: cannot be read \(No such file"):
        load_config("config/config.yaml")
    with pytest.raises(ConfigError, match=r"^nowhere\.yaml: cannot be read \(No such file"):
        load_config("nowhere.yaml")
