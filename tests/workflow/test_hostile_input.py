"""Configuration and data are never executed, wherever they end up."""

import ast
import csv
import re

import lmfit
import numpy as np
import pytest
from small_campaign import COLUMNS, ROOT, check_out, simulated

from freerock.config.campaign import load_campaign
from freerock.config.fit_settings import FitSettings
from freerock.errors import FreerockError
from freerock.identification.least_squares import in_words_of_lmfit
from freerock.identification.settings import check
from freerock.models.block import Block
from freerock.models.given import arithmetic, evaluated
from freerock.records.read import read_record
from freerock.virtual_lab.write_tdms import write_tdms

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
ONLY_EXPR = "identification/least_squares.py"
FORBIDDEN = {"eval", "exec", "__import__", "system", "popen"}
SOLVER = "ops.system"  # of OpenSees: how it stores its equations
UNSAFE_MODULES = {"pickle", "marshal", "shelve", "dill", "joblib", "xmlrpc", "code"}


def test_hostile_texts_do_nothing_in_any_product(tmp_path):
    checkout = check_out(tmp_path / "checkout")
    (checkout / "config/config.yaml").write_text("campaigns: [lab]\n")
    (checkout / "config/campaigns/lab.yaml").write_text(YAML)
    (checkout / "config/campaigns/lab.csv").write_text(COLUMNS + LINES)
    (checkout / "raw/lab").mkdir(parents=True)
    write_tdms(checkout / "raw/lab" / FILE, simulated("squat", 1))
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


HOSTILE = [
    "__import__('os').system('touch pwned')",
    "open('pwned', 'w')",
    "k.__class__",
    "k[0]",
    "(lambda: k)()",
    "[k for k in (1,)][0]",
    "k if k else 1",
    "k and c",
    "k < 1",
    "(k := 1)",
    "f'{k}'",
    "'k'",
    "b'k'",
    "1j",
    "True",
    "None",
    "...",
    "+k",
    "~k",
    "not k",
    "k % 2",
    "k // 2",
    "k @ k",
    "k << 9",
    "k | 1",
    "exp(k)",
    "pi",
    "theta0",
    "c",
    "k; k",
    "k\nimport os",
    "k # ) \n",
    "",
    "*k",
    "k, k",
    "{k}",
    "await k",
    "9**9**9**9",
    "(9**9999)**9999",
    "1e400",
    "1/0",
    "(-1)**0.5",
    "0**-1",
    "-" * 199 + "(",
    "(" * 150 + "k" + ")" * 150,
    "k" + "*k" * 200,
    "1" * 199 + "k",
    "\x00",
    "k\u2028k",
]


@pytest.mark.parametrize("expr", HOSTILE)
def test_an_expression_that_is_no_arithmetic_of_parameters_is_refused_before_it_is_evaluated(
    tmp_path, monkeypatch, expr
):
    """In the configuration, in Python, and in a file of fits that another has written."""
    monkeypatch.chdir(tmp_path)
    refused = r"fits.parameters"
    with pytest.raises(FreerockError, match=refused):
        arithmetic(expr, ("k",))
    given = {"winkler": {"c": {"expr": expr}}}
    if expr:  # none at all ties nothing
        with pytest.raises(FreerockError, match=refused):
            check("winkler", [Block(0.28, 0.07, 5.84)], FitSettings(parameters=given))
        settings = {
            "names": ("k", "c"),
            "values": np.array([6e6, 2e4]),
            "bounds": (np.zeros(2), np.full(2, 1e9)),
        }
        with pytest.raises(FreerockError, match=refused):
            in_words_of_lmfit(
                **settings,
                varied=np.array([True, False]),
                ties=["", expr],
                initial=np.ones(2),
                covariance=np.eye(2),
            )
    assert not list(tmp_path.iterdir())


def test_an_expression_in_the_configuration_is_refused_in_one_line(tmp_path):
    (tmp_path / "lab.csv").write_text(COLUMNS + "one,one.tdms,,squat,mat,low,,,,\n")
    for expr in HOSTILE[:3]:
        text = YAML + f'fits: {{parameters: {{winkler: {{c: {{expr: "{expr}"}}}}}}}}\n'
        (tmp_path / "lab.yaml").write_text(text)
        with pytest.raises(FreerockError, match=r"^[^\n]*lab\.yaml:\d+: fits\.parameters: [^\n]*$"):
            load_campaign(tmp_path / "lab.yaml")
    assert not list(tmp_path.rglob("pwned"))


@pytest.mark.parametrize(
    ("expr", "value"),
    [("k", 3.0), ("-k", -3.0), ("2*k + 1", 7.0), ("(k - 1)/4", 0.5), ("2**k", 8.0), (" k**-1 ", 1 / 3)],
)
def test_arithmetic_is_evaluated_alike_by_itself_and_by_lmfit(expr, value):
    parameters = lmfit.Parameters()
    parameters.add("k", value=3.0)
    parameters.add("c", expr=arithmetic(expr, ("k",)))
    assert parameters["c"].value == pytest.approx(value) == evaluated(expr, {"k": 3.0})


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
    """In package and scripts: no eval, no pickle, no shell, YAML by the safe reader. A text reaches lmfit's
    `expr`, which evaluates it, from `models.given.arithmetic` alone, which refuses all but arithmetic."""
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
            bare = bare if called != SOLVER else ""
            assert bare not in FORBIDDEN and called != "compile", f"{file}:{node.lineno}: {called}"
            assert given.get("shell", "False") == "False", file
            assert given.get("allow_pickle", "False") == "False", file
            if "expr" in given:
                assert given["expr"].startswith("arithmetic(") and file.as_posix().endswith(ONLY_EXPR), file
            assert not (bare in ("Interpreter", "asteval", "literal_eval") or "asteval" in called), file
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
