"""The tutorial, from record files to parameters, as its text says; commands of other pages exist."""

import doctest
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml
from warm import commands

from freerock.cli.subcommands import COMMANDS
from freerock.config.campaign import load_campaign

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(r"(?:<!-- file: (\S+) -->\n)?^( *)```(\w+)\n(.*?)^ *```", re.M | re.S)
NOT_RUN = ("make", ". .venv")  # what sets up the environment in which this test runs


def steps(text):
    """Files to write, as name and content, and commands with their answers, in the order of a page."""
    for name, _, language, body in BLOCK.findall(text):
        if name:
            yield name, body, None
        elif language == "console":
            for command, answer in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", body, re.M):
                yield None, command.strip(), answer


def agrees(printed, answer):
    """Whether an answer is the printed one: … stands for anything, blanks don't count.

    Where a ± stands, numbers need only be `near`.
    """
    if "±" in printed:
        if not near(printed, answer):
            return False
        printed, answer = re.sub(r"\d", "", printed), re.sub(r"\d", "", answer)
    printed, answer = ("\n".join(filter(str.strip, each.splitlines())) for each in (printed, answer))
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    return doctest.OutputChecker().check_output(printed.replace("…", "...") + "\n", answer + "\n", flags)


def near(printed, answer):
    """Whether numbers are the printed ones to 2 % or to their u, and u to half of it."""
    one, other = (re.findall(r"(± )?(\d+\.?\d*)", text) for text in (printed, answer))
    if [is_u for is_u, _ in one] != [is_u for is_u, _ in other]:
        return False
    following = [float(number) if is_u else 0.0 for is_u, number in [*one[1:], ("", "0")]]
    for (is_u, number), u, (_, found) in zip(one, following, other, strict=True):
        value = float(number)
        if abs(float(found) - value) > (value / 2 if is_u else max(0.02 * value, u)):
            return False
    return True


@pytest.mark.parametrize(
    ("answer", "same"),
    [
        ("k = (4.302 ± 0.019)·10⁶, c = 2.13·10⁴", True),
        ("k = (4.330 ± 0.021)·10⁶, c = 2.12·10⁴", True),
        ("k = (4.405 ± 0.021)·10⁶, c = 2.12·10⁴", False),
        ("k = (4.305 ± 0.060)·10⁶, c = 2.12·10⁴", False),
        ("k = (4.305 ± 0.021)·10⁶, c = 2.17·10⁴", False),
        ("k = (4.305 ± 0.021)·10⁷, c = 2.12·10⁴", False),
        ("k = 4.305·10⁶, c = 2.12·10⁴", False),
    ],
)
def test_numbers_beside_an_uncertainty_count_to_two_per_cent(answer, same):
    assert agrees("k = (4.305 ± 0.021)·10⁶, c = 2.12·10⁴", answer) == same


def test_the_tutorial_finds_the_truth(tmp_path):
    for part in ("src", "workflow", "config", "profiles", "docs/tutorial"):
        shutil.copytree(ROOT / part, tmp_path / part)
    shutil.copy2(ROOT / "Snakefile", tmp_path)
    (tmp_path / "raw").mkdir()
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "src"), "COLUMNS": "100"}
    environment["PATH"] = os.pathsep.join([str(commands()), environment["PATH"]])
    for name, what, printed in steps((ROOT / "docs/tutorial.md").read_text(encoding="utf-8")):
        if name:
            (tmp_path / name).write_text(what, encoding="utf-8")
        elif not what.startswith(NOT_RUN):
            done = subprocess.run(
                ["bash", "-c", f"{what} 2>&1"], cwd=tmp_path, env=environment, capture_output=True, text=True
            )
            assert done.returncode == ("still to be filled in" in printed), f"{what}\n{done.stdout}"
            assert agrees(printed, done.stdout), f"$ {what}\n{done.stdout}\ninstead of\n{printed}"
    secret = dict(re.findall(r"(\w+) = (\S+) N", (tmp_path / "secret.txt").read_text()))
    lines = (tmp_path / "results/stones/tables/parameters.csv").read_text().splitlines()
    rows = [dict(zip(lines[0].split(","), line.split(","), strict=True)) for line in lines[1:]]
    found = [each for each in rows if each["model"] == "hunt_crossley" and each["parameter"] in secret]
    assert len(found) >= 6  # k and λ of three records
    for each in found:
        value, truth = float(each["value"]), float(secret[each["parameter"]])
        assert abs(value - truth) < 4 * float(each["stderr"]) + 1e-3 * truth, each


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_and_links_of_a_page_are_there(page):
    text = page.read_text(encoding="utf-8")
    for command in re.findall(r"(?:`|\$ )freerock ([a-z][a-z-]+)", text):
        assert command in COMMANDS, command
    for target in re.findall(r"(?:`|^)make ([a-z-]+)", text, re.M):
        assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text(), re.M), target
    for module in re.findall(r"python -m (freerock[\w.]*)", text):
        path = ROOT / "src" / module.replace(".", "/")
        assert path.with_suffix(".py").is_file() or (path / "__init__.py").is_file(), module
    for link in re.findall(r"\]\(((?!https?:|#)[^)\s#]+)", text):
        assert (page.parent / link).exists(), link


def test_files_to_change_are_there():
    for page in (ROOT / "CONTRIBUTING.md", ROOT / "docs/architecture.md"):
        for path in re.findall(r"`([a-z_/]+\.(?:py|csv|smk|yaml|md))`", page.read_text(encoding="utf-8")):
            assert (ROOT / "src/freerock" / path).exists() or (ROOT / path).exists(), path


BASE = {
    "title": "Snippets",
    "origin": "measured",
    "blocks": {name: {"height_m": 0.3, "width_m": 0.07, "mass_kg": 5} for name in ("block1", "config2")},
    "foundations": {"foundation1": {}, "marble": {}},
    "lasers": {
        name: {"beam": "horizontal", "position_m": position_m, "range_m": 0.1}
        for name, position_m in {"laser1": 0.2, "upper": 0.24, "lower": 0.06}.items()
    },
}


@pytest.mark.parametrize(
    ("language", "body"),
    [
        (language, body)
        for page in sorted((ROOT / "docs/how-to").glob("*.md"))
        for _, _, language, body in BLOCK.findall(page.read_text(encoding="utf-8"))
        if language in ("yaml", "csv")
    ],
)
def test_configurations_of_the_how_tos_are_accepted(language, body, tmp_path):
    snippet = yaml.safe_load(body) if language == "yaml" else {}
    keys = {key: BASE[key] | snippet.get(key, {}) for key in ("blocks", "foundations", "lasers")}
    block, foundation = "block1", "foundation1"
    if "plan" in snippet:  # every block on every foundation
        block, foundation = "config2", "marble"
        keys |= {"blocks": {block: BASE["blocks"][block]}, "foundations": {foundation: {}}}
    line = f"test,file,block,foundation,laser\na,a.tdms,{block},{foundation},laser1\n"
    (tmp_path / "lab.yaml").write_text(yaml.safe_dump(BASE | snippet | keys))
    (tmp_path / "lab.csv").write_text(body if language == "csv" else line)
    assert load_campaign(tmp_path / "lab.yaml").records
