"""The command `freerock`: what it answers, what it loads, and its exit codes."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from freerock.cli import progress_command
from freerock.cli import subcommands as cli

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


def test_help_documents_the_exit_codes():
    assert cli.EXIT_CODES in freerock("--help").stdout


def test_the_version_is_that_of_the_citation(capsys):
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.M)
    with pytest.raises(SystemExit) as done:
        cli.main(["--version"])
    assert done.value.code == 0
    assert capsys.readouterr().out == f"freerock {cited[1]}\n"


def loaded_after(code):
    """Libraries that take long to load, of those that Python has after a piece of code."""
    slow = "{'numpy', 'yaml', 'scipy', 'matplotlib', 'numba', 'lmfit', 'netCDF4', 'snakemake'}"
    command = [sys.executable, "-c", f"import sys; {code}; print(sorted({slow} & {{*sys.modules}}))"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    return done.stdout


def test_check_of_the_shipped_campaign_loads_little():
    told = loaded_after("from freerock.cli.subcommands import main; main(['check', 'palermo_virtual'])")
    assert told == "palermo_virtual: 6 records, 3 blocks, 2 foundations: nothing to correct\n['numpy']\n"


def test_help_loads_no_library():
    assert loaded_after("import freerock.cli.subcommands as c; c._parser()") == "[]\n"


def test_every_module_is_a_command():
    modules = {path.stem for path in (ROOT / "src/freerock/cli").glob("[!_]*.py")}
    assert modules - {"subcommands"} == {f"{name.replace('-', '_')}_command" for name in cli.COMMANDS}


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_every_command_has_an_example_and_the_exit_codes(command, capsys):
    with pytest.raises(SystemExit) as done:
        cli.main([command, "--help"])
    text = capsys.readouterr().out
    assert done.value.code == 0
    assert f"freerock {command} " in text.partition("example:")[2]
    assert cli.EXIT_CODES in text


def test_plan_prints_its_table_and_writes_the_same_bytes_each_time(small, capsys):
    written = []
    for folder in ("one", "two"):
        assert cli.main(["plan", str(small / "lab.yaml"), "--into", str(small / folder)]) == 0
        out = capsys.readouterr().out
        assert out.startswith("Standard errors by noise alone in %")
        places = [f"{small / folder / name}.csv, .pdf, .png" for name in ("plan", "total")]
        assert out.splitlines()[-3:] == [
            f"written: {each}" for each in (*places, small / folder / "budget.csv")
        ]
        written.append({path.name: path.read_bytes() for path in (small / folder).iterdir()})
    drawn = {f"{name}.{suffix}" for name in ("plan", "total") for suffix in ("csv", "pdf", "png")}
    assert set(written[0]) == {*drawn, "budget.csv"}
    assert written[0] == written[1]


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


def test_a_terminal_without_greek_letters_is_no_error(small):
    command = [sys.executable, "-m", "freerock.cli", "plan", "lab.yaml", "--into", "ascii"]
    environment = os.environ | {"PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, cwd=small, env=environment, capture_output=True)
    assert done.returncode == 0, done.stderr
    assert rb"\xb0" in done.stdout


def test_an_error_of_its_own_is_one_line_and_a_traceback_in_the_log(tmp_path, monkeypatch, capsys):
    def run(chosen):
        raise ZeroDivisionError("division\nby zero")

    monkeypatch.setattr(progress_command, "run", run)
    monkeypatch.chdir(tmp_path)
    assert cli.main(["progress"]) == 3
    line = "freerock progress: ZeroDivisionError: division; report it with freerock.log\n"
    assert capsys.readouterr().err == line
    log = (tmp_path / "freerock.log").read_text(encoding="utf-8")
    assert line in log
    assert "Traceback (most recent call last)" in log
    assert cli.main(["progress", "--debug"]) == 3
    assert capsys.readouterr().err.startswith("Traceback (most recent call last)")


def test_a_subcommand_that_cannot_be_imported_is_an_error_of_its_own(tmp_path, monkeypatch, capsys):
    def broken(name):
        raise ImportError("no library")

    monkeypatch.setattr(cli.importlib, "import_module", broken)
    monkeypatch.chdir(tmp_path)
    assert cli.main(["progress"]) == 3
    line = "freerock progress: ImportError: no library; report it with freerock.log\n"
    assert capsys.readouterr().err == line
    assert "Traceback" in (tmp_path / "freerock.log").read_text(encoding="utf-8")


def test_a_reader_that_closes_the_pipe_is_no_error(small):
    command = [sys.executable, "-m", "freerock.cli", "plan", "lab.yaml"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=small) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 0
    assert (small / "results/lab/plan/plan.png").exists()


def test_a_system_without_locks_is_refused_in_one_line(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(cli.sys, "platform", "win32")
    assert cli.main(["check"]) == 1
    assert capsys.readouterr().err == (
        "freerock: needs the file locks of a POSIX system; use Linux, macOS or WSL\n"
    )


def test_a_name_that_no_file_can_have_is_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    commands = ("inspect", "plan", "review", "simulate", "check", "verify", "supplement")
    for command, name in (*((each, "a" * 300) for each in commands), ("check", f"{'a' * 300}.yaml")):
        assert cli.main([command, name]) == 1
        (line,) = capsys.readouterr().err.splitlines()
        assert re.search(
            r": .*(File name too long.*; shorten (it|its name)|has 300 characters; use 100 at most)$", line
        )


@pytest.mark.parametrize("port", ["80000", "-1", "²", "1.5", "9" * 5000])
def test_a_port_that_is_none(port, capsys):
    with pytest.raises(SystemExit):
        cli.main(["review", "lab", f"--port={port}"])
    assert "is no port, from 0 to 65535" in capsys.readouterr().err.splitlines()[-1]


def test_without_compiled_code_nothing_is_solved(small):
    done = subprocess.run(
        [sys.executable, "-m", "freerock.cli", "plan", str(small / "lab.yaml")],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
    )
    told = "NUMBA_DISABLE_JIT: is set: nothing is compiled, and a fit would take hours; unset it"
    assert (done.returncode, done.stderr.splitlines()[-1]) == (1, told)
