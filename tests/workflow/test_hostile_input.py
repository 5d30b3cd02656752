"""Configuration and data are never executed, wherever they end up."""

import ast
import csv
import re

import numpy as np
import pytest
from small_campaign import COLUMNS, ROOT, check_out, simulated

from freerock.config.campaign import load_campaign
from freerock.errors import FreerockError
from freerock.records.read import read_record
from freerock.virtual_lab.tdms import write_record

FILE = "$(touch pwned);'` \".tdms"
SCRIPT = "</script><script>alert(1)</script>"
YAML = f"""\
title: '=cmd|" /C calc"!A0 {SCRIPT}'
summary: '{{{{ 7*7 }}}} {{% raw %}} {SCRIPT}'
origin: simulated
blocks:
  squat: {{height_m: 0.14, width_m: 0.07, mass_kg: 2.98, label: '=1 \\input{{/etc/passwd}} $x_{{$ {SCRIPT}'}}
foundations:
  mat: {{label: "_@SUM(A1) $5\\n| {{wildcards}} [x](javascript:alert) {SCRIPT}"}}
lasers:
  low: {{beam: horizontal, position_m: 0.1, range_m: 0.1}}
"""
LINES = f"""\
good,"{FILE.replace('"', '""')}",,squat,mat,low,,,,+1+1 {SCRIPT}
out,"{FILE.replace('"', '""')}",,squat,mat,low,record,,=HYPERLINK("x") {SCRIPT},-1
""".replace('HYPERLINK("x")', "HYPERLINK('x')")
FORBIDDEN = {"eval", "exec", "__import__", "system", "popen"}
UNSAFE_MODULES = {"pickle", "marshal", "shelve", "dill", "joblib", "xmlrpc", "code"}


def test_hostile_texts_do_nothing_in_any_product(tmp_path):
    checkout = check_out(tmp_path / "checkout")
    (checkout / "config/config.yaml").write_text("campaigns: [lab]\n")
    (checkout / "config/campaigns/lab.yaml").write_text(YAML)
    (checkout / "config/campaigns/lab.csv").write_text(COLUMNS + LINES)
    (checkout / "raw/lab").mkdir(parents=True)
    write_record(checkout / "raw/lab" / FILE, simulated("squat", 1))
    done = checkout.snakemake()
    assert done.returncode == 0, done.stderr
    assert not list(checkout.folder.rglob("pwned"))

    page = (checkout / "results/lab/report.html").read_text(encoding="utf-8")
    assert "<script>alert" not in page
    assert "alert(1)" in page
    assert "{{ 7*7 }}" in page
    for path in (checkout / "results/lab/tables").glob("*.md"):
        text = path.read_text(encoding="utf-8")
        assert "<script" not in text and "[x](" not in text
        rows = [line for line in text.splitlines() if line.startswith("|")]
        assert len({row.replace(r"\|", "").count("|") for row in rows}) == (path.stem != "methods"), text
    assert "$5 \\| {wildcards}" in (checkout / "results/lab/tables/table2.md").read_text(encoding="utf-8")
    for path in (checkout / "results/lab/tables").glob("*.tex"):
        assert "\\input{/etc" not in path.read_text(encoding="utf-8")
    cells = 0
    for path in (checkout / "results/lab").rglob("*.csv"):
        with open(path, newline="", encoding="utf-8") as table:
            for cell in (cell for row in csv.reader(table) for cell in row):
                cells += 1
                assert cell[:1] not in ("=", "+", "@", "\t") and not re.match(r"-(?!\d|inf|nan)", cell), path
    assert cells > 1000


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("models", "[\"__import__('os').system('touch pwned')\"]"),
        ("free", "{hunt_crossley: [\"k*__import__('os').getpid()\"]}"),
        ("debonding", "!!python/object/apply:os.getcwd []"),
    ],
)
def test_expressions_and_objects_in_the_configuration_are_refused(tmp_path, key, value):
    (tmp_path / "lab.csv").write_text(COLUMNS + "one,one.tdms,,squat,mat,low,,,,\n")
    text = YAML + f"fits: {{{key}: {value}}}\n"
    (tmp_path / "lab.yaml").write_text(text)
    with pytest.raises(FreerockError, match=r"lab\.yaml:\d+"):
        load_campaign(tmp_path / "lab.yaml")
    assert not list(tmp_path.rglob("pwned"))


def test_file_names_that_are_patterns_are_refused(tmp_path):
    (tmp_path / "lab.yaml").write_text(YAML)
    (tmp_path / "lab.csv").write_text(COLUMNS + "one,{x}.tdms,,squat,mat,low,,,,\n")
    with pytest.raises(FreerockError, match=r"'\{x\}\.tdms' has braces.*; rename it"):
        load_campaign(tmp_path / "lab.yaml")


class Harmful:
    """Its pickle would make a file when it is read."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return open, (str(self.path), "w")


@pytest.mark.parametrize("suffix", ["npy", "mat", "h5", "nc", "csv", "xlsx", "tdms", "lvm"])
def test_a_pickle_under_any_name_is_not_unpickled(tmp_path, suffix):
    harmful = np.empty(1, object)
    harmful[0] = Harmful(tmp_path / "pwned")
    with open(tmp_path / f"record.{suffix}", "wb") as file:
        np.save(file, harmful, allow_pickle=True)
    with pytest.raises(FreerockError, match=rf"record\.{suffix}: "):
        read_record(tmp_path / f"record.{suffix}")
    assert not (tmp_path / "pwned").exists()


def test_no_module_evaluates_text_or_unpickles():
    """In package and scripts: no eval, no pickle, no shell, YAML by the safe reader, no lmfit expr."""
    files = [*(ROOT / "src").rglob("*.py"), *(ROOT / "workflow/scripts").glob("*.py")]
    assert len(files) > 50
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import | ast.ImportFrom):
                names = {getattr(node, "module", None), *(alias.name for alias in node.names)}
                assert not names & UNSAFE_MODULES, file
            if not isinstance(node, ast.Call):
                continue
            called = ast.unparse(node.func)
            given = {word.arg: ast.unparse(word.value) for word in node.keywords}
            bare = called.rpartition(".")[2]
            assert bare not in FORBIDDEN and called != "compile", f"{file}:{node.lineno}: {called}"
            assert given.get("shell", "False") == "False", file
            assert given.get("allow_pickle", "False") == "False", file
            assert "expr" not in given, file
            assert bare not in ("read_pickle", "unsafe_load", "full_load"), file
            if called == "YAML":
                assert given["typ"] == "'safe'", file


def test_every_dependency_is_pinned_with_its_checksums():
    locks = ("requirements.lock", "requirements-peers.lock", "profiles/slurm/requirements.lock")
    text = "".join((ROOT / lock).read_text(encoding="utf-8") for lock in locks)
    pinned = re.split(r"^(?=\w)", text, flags=re.M)[1:]
    assert len(pinned) > 70
    for each in pinned:
        assert re.match(r"[\w.-]+(\[\w,-]+\])?==[\w.]+ .*--hash=sha256:[0-9a-f]{64}", each, re.S), each[:60]
