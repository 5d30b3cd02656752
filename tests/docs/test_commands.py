"""Every command in README and docs: run in a copy of the checkout, its answer compared with the printed one.

Commands stand in blocks (console with a $ before each and its answer below; sh) or in the text between
backticks. A file shown in a block after <!-- file: PATH --> is written before the next command.
"""

import doctest
import functools
import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml
from small_campaign import note_meanings
from warm import commands

from freerock.config.campaign import load_campaign
from freerock.config.record import Record
from freerock.virtual_lab.truth import read_truth

ROOT = Path(__file__).parents[2]
PARTS = ["src", "workflow", "config", "raw", "profiles", "examples", "docs/tutorial", "Snakefile"]
FILES = [
    ROOT / "README.md",
    *sorted((ROOT / "docs").rglob("*.md")),
    *ROOT.glob("*/README.md"),
    *ROOT.glob("raw/*/README.md"),
]

NOT_RUN = {  # beginning of a command: why not; what Snakemake would do is planned all the same
    "git clone": "the copy is the checkout",
    "cd freerock": "the copy is the current folder",
    "make": "sets up the environment in which this test runs; .ci/run does it on a fresh machine",
    ". .venv/bin/activate": "the environment is active",
    "pip install": "changes the environment in which this test runs",
    "sbatch": "needs a cluster",
    "snakemake --profile": "needs a cluster",
    "snakemake --executor": "needs a cluster",
    "snakemake --report": "needs results; made by tests/workflow/test_snakemake_report.py",
    "freerock review": "serves until it is stopped; run by tests/browser/test_review_page.py",
    "freerock verify": "needs results; run by tests/workflow/test_ledger.py",
    "snakemake --config verify=true": "needs results; run by tests/workflow/test_ledger.py",
    "snakemake --unlock": "after a killed run only",
    "snakemake studies": "an hour; small: run by tests/workflow/test_studies_target.py",
    "python -m freerock_bench": "minutes, or needs the results of the studies",
    "python benchmarks/": "minutes; measures speed",
    "snakemake --config campaigns=wooden_blocks": "minutes; the campaign is checked, its records read",
    "snakemake --config campaigns=foreign": "minutes; part of it is run by tests/bench/test_foreign.py",
    "snakemake": "the shipped campaign is analysed by tests/workflow/test_palermo.py",
    "python -m freerock.virtual_lab": "the bytes are compared by the tests of the virtual laboratory",
}
RUN_AFTER_ALL = ("snakemake --config campaigns=stones", "python -m freerock_bench.golden.grade")
ONLY_READS = re.compile(r"^snakemake --dry-run\b|^freerock check\b|--(?:help|version)$")
PLACEHOLDER = re.compile(r"NAME|REPOSITORY|FOLDER|FILE|<|…|/data/|results/[ABab]\b|stones,marble")
INLINE = re.compile(
    r"`((?:freerock|snakemake|make|python -m freerock(?:_bench)?\.[\w.]+|python benchmarks/\w+)(?: [^`]+)?)`"
)
BLOCK = re.compile(r"(?:<!-- file: (\S+) -->\n)?^( *)```(\w+)\n(.*?)^ *```", re.M | re.S)


def steps(path):
    """(kind, command or file name, answer or content) in the order of a file."""
    text = path.read_text(encoding="utf-8")
    for match in BLOCK.finditer(text):
        name, indent, language, body = match.groups()
        body = re.sub(rf"^{indent}", "", body, flags=re.M)
        if name:
            yield "write", name, body
        elif language == "console":
            for command, answer in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", body, re.M):
                yield "run", command.strip(), answer
        elif language in ("sh", "bash"):
            for line in re.sub(r"\\\n *", "", body).splitlines():
                if command := re.sub(r"\s+# .*|^#.*", "", line).strip():
                    yield "run", command, None
    for command in dict.fromkeys(INLINE.findall(BLOCK.sub("", text))):
        yield "run", command, None


def known(command):
    """Whether it is a command of this project, or one that only reads."""
    return re.match(r"(freerock|snakemake|python (-m freerock(_bench)?\.|docs/)|cat) ?", command) is not None


def left_out(command):
    longest = max((start for start in NOT_RUN if f"{command} ".startswith(start)), key=len, default=None)
    return None if command.startswith(RUN_AFTER_ALL) else longest


def test_what_is_left_out_is_there():
    printed = {left_out(command) for path in FILES for kind, command, _ in steps(path) if kind == "run"}
    needs_cluster = {start for start, why in NOT_RUN.items() if why == "needs a cluster"}
    assert set(NOT_RUN) - printed <= needs_cluster


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """A function that makes a copy of the checkout."""

    def make(name):
        folder = tmp_path_factory.mktemp(name) / "copy"
        for part in PARTS:
            source, target = ROOT / part, folder / part
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copytree(source, target) if source.is_dir() else shutil.copy2(source, target)
        campaign = folder / "config/campaigns/palermo_virtual.yaml"
        before, plan, keys = campaign.read_text(encoding="utf-8").partition("\nplan:\n")
        few = re.sub(r"\[(\S+), .+\]", r"[\1]", keys)  # of rates and angles the first: all take a minute
        campaign.write_text(before + plan + few, encoding="utf-8")
        note_meanings(folder)
        return folder

    return make


def run(command, folder):
    environment = os.environ | {"PYTHONPATH": str(folder / "src")}
    environment["PATH"] = os.pathsep.join([str(commands()), environment["PATH"]])
    environment["COLUMNS"] = "100"
    done = subprocess.run(
        ["bash", "-c", command],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    return done.returncode, done.stdout


def agrees(printed, answer):
    """Whether an answer is the printed one, where … stands for anything and blanks don't count.

    Nor do the digits of identified values, which end as the processor has it.
    """
    if "±" in printed:
        printed, answer = re.sub(r"\d", "", printed), re.sub(r"\d", "", answer)
    printed, answer = (re.sub(r"\n\s*\n", "\n<BLANKLINE>\n", each.strip()) for each in (printed, answer))
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    printed, answer = (each.replace("<BLANKLINE>\n", "") for each in (printed, answer))
    return doctest.OutputChecker().check_output(printed.replace("…", "...") + "\n", answer + "\n", flags)


@pytest.fixture(scope="module")
def told(copy):
    """What commands that only read answer in a copy of the checkout, each run once for all texts."""
    folder = copy("untouched")
    return functools.cache(lambda command: run(command, folder))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_commands_do_what_the_text_says(path, copy, told):
    folder = None  # a copy for this text, from the first step on that writes
    for kind, what, printed in steps(path):
        if kind == "write":
            folder = folder or copy(path.stem)
            (folder / what).write_text(printed, encoding="utf-8")
            continue
        command = what
        if reason := left_out(command):
            plan = command.startswith("snakemake") and not NOT_RUN[reason].startswith("needs")
            if not plan or PLACEHOLDER.search(command):
                continue
            command = command.replace("snakemake", "snakemake --dry-run", 1)
        elif PLACEHOLDER.search(command):
            words = 3 if command.startswith("python -m") else 2
            command = f"{' '.join(shlex.split(command)[:words])} --help"  # at least its subcommand is there
        elif command in ("freerock add", "freerock plan", "freerock inspect"):
            command += " --help"
        assert known(command), f"{command}: run it here only if it is harmless, or list it in NOT_RUN"
        if folder is None and ONLY_READS.search(command):
            code, answer = told(command)
        else:
            folder = folder or copy(path.stem)
            code, answer = run(command, folder)
        unfilled = printed is not None and "is still to be filled in" in printed
        assert code == (1 if unfilled else 0), f"{command}\n{answer}"
        if printed is not None and command == what:
            assert agrees(printed, answer), f"$ {command}\n{answer}\ninstead of\n{printed}"
    if path.name == "tutorial.md":
        right_at_the_end(folder)


def right_at_the_end(folder):
    """k and λ of each record are those of the scene, within four standard errors and within a thousandth."""
    secret = dict(re.findall(r"(\w+) = (\S+) N", (folder / "secret.txt").read_text()))
    lines = (folder / "results/stones/tables/parameters.csv").read_text().splitlines()
    columns = lines[0].split(",")
    found = [dict(zip(columns, line.split(","), strict=True)) for line in lines[1:]]
    found = [each for each in found if each["model"] == "hunt_crossley" and each["parameter"] in secret]
    assert len(found) >= 6  # k and λ of three records
    for each in found:
        value, truth = float(each["value"]), float(secret[each["parameter"]])
        assert abs(value - truth) < 4 * float(each["stderr"]) + 1e-3 * truth, each


def test_the_tutorial_takes_few_commands():
    commands = [what for kind, what, _ in steps(ROOT / "docs/tutorial.md") if kind == "run"]
    in_blocks = commands[: commands.index("cat secret.txt") + 1]
    assert len(in_blocks) < 15


@pytest.mark.parametrize("seed", [7])
def test_another_scene_is_recovered_as_well(copy, seed):
    """The tutorial's steps with a scene drawn by lot, without its printed answers."""
    folder = copy("another")
    code, printed = run(f"python docs/tutorial/another_laboratory.py stick {seed}", folder)
    assert code == 0, printed
    numbers = re.findall(r"\d+\.\d+", printed)
    keys = ("height_m", "width_m", "mass_kg", "position_m", "range_m")
    filled = dict(zip(keys, numbers, strict=True)) | {
        "title": "Stones",
        "origin": "simulated",
        "beam": "horizontal",
    }
    assert run("freerock new-campaign stones --from stick", folder)[0] == 0
    campaign = folder / "config/campaigns/stones.yaml"
    text = re.sub(r"(\w+): FILL_IN", lambda match: f"{match[1]}: {filled[match[1]]}", campaign.read_text())
    campaign.write_text(text + "fits: {models: [hunt_crossley]}\n")
    assert run("freerock check stones", folder)[0] == 0
    code, printed = run(
        "snakemake --cores 2 results/stones/tables/parameters.csv --config campaigns=stones", folder
    )
    assert code == 0, printed
    right_at_the_end(folder)


SNIPPETS = [
    (path, language, body)
    for path in sorted((ROOT / "docs/how-to").glob("*.md"))
    for _, _, language, body in BLOCK.findall(path.read_text(encoding="utf-8"))
    if language in ("yaml", "csv")
]
LASER = {"beam": "horizontal", "position_m": 0.2, "range_m": 0.1}
BASE = {
    "title": "Snippets",
    "origin": "measured",
    "blocks": {name: {"height_m": 0.3, "width_m": 0.07, "mass_kg": 5} for name in ("block1", "config2")},
    "foundations": {"foundation1": {}, "marble": {}},
    "lasers": {
        name: LASER | {"position_m": position_m}
        for name, position_m in {"laser1": 0.2, "upper": 0.24, "lower": 0.06}.items()
    },
}
LINE = "test,file,block,foundation,laser\na,a.tdms,block1,foundation1,laser1\n"


@pytest.mark.parametrize(("path", "language", "body"), SNIPPETS)
def test_snippets_are_sound(path, language, body, tmp_path):
    snippet = yaml.safe_load(body) if language == "yaml" else {}
    named = {key: BASE[key] | snippet.get(key, {}) for key in ("blocks", "foundations", "lasers")}
    line = LINE
    if "plan" in snippet:  # every block on every foundation
        named |= {"blocks": {"config2": BASE["blocks"]["config2"]}, "foundations": {"marble": {}}}
        line = LINE.replace("foundation1", "marble").replace("block1", "config2")
    (tmp_path / "lab.yaml").write_text(yaml.safe_dump(BASE | snippet | named))
    (tmp_path / "lab.csv").write_text(body if language == "csv" else line)
    lab = load_campaign(tmp_path / "lab.yaml")
    assert all(isinstance(record, Record) for record in lab.records)


def test_the_truth_of_the_shipped_campaigns_is_readable():
    for campaign in ("palermo_virtual", "wooden_blocks"):
        assert read_truth(ROOT / f"raw/{campaign}/truth.json")
