"""The mutation run: what is changed, where, and which tests are asked."""

import ast
from functools import cache
from itertools import chain
from pathlib import Path

import pytest

from freerock_bench import mutation
from freerock_bench.mutation import ROOT, Mutant, changed, drawn_mutants, mutants_of, related_tests


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("a < b", "a <= b"),
        ("a != b", "a == b"),
        ("a + b", "a - b"),
        ("a / b", "a * b"),
        ("a and b", "a or b"),
        ("not a", "a"),
        ("-a", "a"),
        ("True", "False"),
        ("3", "4"),
        ("0.5", "2.0"),
        ("'text'", ""),
        ("f(a)", ""),
        ("'a' + b", ""),
        ("a < b < c", ""),
    ],
)
def test_one_expression_is_changed(before, after):
    assert changed(ast.parse(before, mode="eval").body) == after


def test_a_mutant_is_the_file_with_one_expression_changed():
    file = ROOT / "src/freerock/runs/verdict.py"
    some = list(mutants_of(file))
    assert some and all(isinstance(each, Mutant) for each in some)
    for each in some:
        one, other = file.read_text(encoding="utf-8").splitlines(), each.text().splitlines()
        assert ast.dump(ast.parse(each.text())) != ast.dump(ast.parse(file.read_text(encoding="utf-8")))
        pairs = enumerate(zip(one, other, strict=True), 1)
        assert [i for i, (before, after) in pairs if before != after] == [each.node.lineno]


def test_mutants_are_drawn_by_their_seed_over_all_rooms_in_turn(monkeypatch):
    listed = cache(lambda file: [*mutants_of(file)])  # each file is read once
    monkeypatch.setattr(mutation, "mutants_of", listed)
    drawn = drawn_mutants(40, 3)
    rooms = [each.room for each in drawn]
    assert len({*rooms}) == 19 and max(map(rooms.count, rooms)) - min(map(rooms.count, rooms)) <= 1
    assert [each.text() for each in drawn] == [each.text() for each in drawn_mutants(40, 3)]
    assert [each.text() for each in drawn] != [each.text() for each in drawn_mutants(40, 4)]


def test_related_tests_a_module_import_it_or_one_that_does():
    names = [path.name for path in related_tests(ROOT / "src/freerock/runs/verdict.py")]
    assert names[0].startswith("test_") and "test_verdict.py" in names[:2]
    assert len(names) >= mutation.AT_ONCE
    assert related_tests(ROOT / "src/freerock/runs/impact_kernel.py")


def test_a_bug_is_caught_in_a_copy(tmp_path):
    checkout, file = Path(tmp_path), ROOT / "src/freerock/runs/verdict.py"
    mutation.shutil.copytree(ROOT / "tests", checkout / "tests")
    mutation.shutil.copy(ROOT / "pyproject.toml", checkout)
    worse = next(each for each in mutants_of(file) if "1" in each.before)
    row = mutation.tried(worse, checkout)
    assert row["caught"] and row["room"] == "runs" and "test_verdict.py::" in row["by"]
    assert (checkout / "src/freerock/runs/verdict.py").read_text(encoding="utf-8") == worse.text()


def test_all_related_tests_are_asked_then_the_kept_numbers_then_slow_ones(monkeypatch, tmp_path):
    asked, file = [], ROOT / "src/freerock/jobs/code_identity.py"
    monkeypatch.setattr(mutation, "caught_by", lambda tests, _: asked.append(tests) or "")
    assert not mutation.tried(next(mutants_of(file)), tmp_path)["caught"]
    at = asked.index(mutation.KEPT)
    assert [*chain(*asked[:at])] == [str(path.relative_to(ROOT)) for path in related_tests(file)]
    assert ["tests/workflow/test_code_checksum.py"] in asked[at:] and max(map(len, asked)) <= mutation.AT_ONCE


@pytest.mark.parametrize("fails_anyway", [False, True])
def test_what_fails_without_the_bug_catches_none(monkeypatch, tmp_path, fails_anyway):
    file = ROOT / "src/freerock/jobs/code_identity.py"
    mutant, copied = next(mutants_of(file)), tmp_path / file.relative_to(ROOT)

    def caught_by(tests, _):
        with_bug = copied.read_text(encoding="utf-8") == mutant.text()
        return "late" * (tests[0].startswith("tests/workflow/test_") and (with_bug or fails_anyway))

    monkeypatch.setattr(mutation, "caught_by", caught_by)
    assert mutation.tried(mutant, tmp_path)["by"] == ("" if fails_anyway else "late")
    monkeypatch.setattr(mutation, "caught_by", lambda tests, _: "kept" * (tests == mutation.KEPT))
    assert mutation.tried(mutant, tmp_path)["by"] == "kept"
