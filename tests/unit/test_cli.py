"""The command `freerock`: what it answers, what it loads, and its exit codes."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from freerock.cli import compare_command
from freerock.cli import subcommands as cli
from freerock.files import sha256, write_json

ROOT = Path(__file__).parents[2]
PALERMO = ROOT / "config/campaigns/palermo_virtual.yaml"


def freerock(*arguments, folder=ROOT):
    command = [sys.executable, "-m", "freerock.cli", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder)


@pytest.fixture
def small(tmp_path):
    """The virtual campaign with a plan of one case."""
    text = PALERMO.read_text(encoding="utf-8").partition("plan:")[0]
    text += "plan:\n  expected: {marble: {housner: {r: 0.958}}, aerstop: {housner: {r: 0.895}}}\n"
    text += "  sensors: {laser: {noise_v: 0.002}}\n  durations_s: [2]\n"
    (tmp_path / "lab.yaml").write_text(text, encoding="utf-8")
    (tmp_path / "lab.csv").write_bytes(PALERMO.with_suffix(".csv").read_bytes())
    return tmp_path


def test_the_version_is_that_of_the_citation(capsys):
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.M)
    with pytest.raises(SystemExit) as done:
        cli.main(["--version"])
    assert done.value.code == 0
    assert capsys.readouterr().out == f"freerock {cited[1]}\n"


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_every_command_has_an_example_and_the_exit_codes(command, capsys):
    with pytest.raises(SystemExit) as done:
        cli.main([command, "--help"])
    text = capsys.readouterr().out
    assert done.value.code == 0
    assert f"freerock {command} " in text.partition("example:")[2]
    assert cli.EXIT_CODES in text


def test_plan_prints_its_table_and_writes_it(small, capsys):
    assert cli.main(["plan", str(small / "lab.yaml"), "--into", str(small / "plan.csv")]) == 0
    out = capsys.readouterr().out
    assert "Housner r" in out and out.splitlines()[-1] == f"written: {small / 'plan.csv'}"
    assert (small / "plan.csv").read_text(encoding="utf-8").startswith("block,foundation,")


def test_a_refused_file_is_reported_in_lines_without_a_traceback(small):
    (small / "lab.yaml").write_text((small / "lab.yaml").read_text().replace("noise_v", "noise_volt"))
    done = freerock("plan", "lab.yaml", folder=small)
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "plan.sensors.laser.noise_volt: unknown key; did you mean 'noise_v'?" in done.stderr
    assert "Traceback" in (small / cli.LOG).read_text(encoding="utf-8")
    assert "Traceback" in freerock("plan", "lab.yaml", "--debug", folder=small).stderr


def test_a_wrong_command_line():
    assert freerock("plan").returncode == 2
    assert freerock("plam", "x.yaml").returncode == 2
    assert freerock().returncode == 2


def test_an_error_of_its_own_is_one_line_and_a_traceback_in_the_log(tmp_path, monkeypatch, capsys):
    def run(chosen):
        raise ZeroDivisionError("division\nby zero")

    monkeypatch.setattr(compare_command, "run", run)
    monkeypatch.chdir(tmp_path)
    assert cli.main(["compare", "a", "b"]) == 3
    line = "freerock compare: ZeroDivisionError: division; report it with freerock.log\n"
    assert capsys.readouterr().err == line
    log = (tmp_path / "freerock.log").read_text(encoding="utf-8")
    assert line in log
    assert "Traceback (most recent call last)" in log
    assert cli.main(["compare", "a", "b", "--debug"]) == 3
    assert capsys.readouterr().err.startswith("Traceback (most recent call last)")


def test_verify_says_of_each_campaign_how_many_files_differ(small, monkeypatch, capsys):
    monkeypatch.chdir(small)
    Path("config/campaigns").mkdir(parents=True)
    for name, changed in {"one": 1, "two": 2, "sound": 0}.items():
        for suffix in ("yaml", "csv"):
            copy = Path(f"config/campaigns/{name}.{suffix}")
            copy.write_bytes(Path(f"lab.{suffix}").read_bytes())
        listed = {f"{name}.csv": "0" * 64, f"{name}.md": "0" * 64} if changed else {}
        if changed == 1:
            Path(f"{name}.md").write_bytes(b"")
            listed[f"{name}.md"] = sha256(f"{name}.md")
        write_json(f"results/{name}/provenance.json", {"inputs": {}, "products": listed})
    assert cli.main(["verify", "one", "sound", "two"]) == 1
    one, two = capsys.readouterr().err.splitlines()
    assert one.startswith("results/one: ") and " 1 of 2 files; " in one
    assert two.startswith("results/two: ") and " 2 of 2 files; " in two
