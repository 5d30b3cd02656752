"""YAML: values are what they look like, and no file makes more work than a configuration may."""

import resource
import time

import pytest

from freerock.bounds import YAML_BYTES, YAML_NODES
from freerock.config.yaml_lines import read_yaml

MEANT = {
    "017": 17,
    "08": 8,
    "0o17": 15,
    "0x1F": 31,
    "1e3": 1000.0,
    "6.77e+6": 6.77e6,
    ".5": 0.5,
    "-3": -3,
    "1:30": "1:30",
    "1:30.5": "1:30.5",
    "1,5": "1,5",
    "yes": "yes",
    "off": "off",
    "true": True,
    "~": None,
    "2017-05-01": "2017-05-01",
    "2017-13-45": "2017-13-45",
    "=": "=",
    "!!str 5": "5",
    "'5'": "5",
}
REFUSED = {
    "!!bool x": "1: the tag 'tag:yaml.org,2002:bool' has no meaning here",
    "!!int ''": "1: the tag 'tag:yaml.org,2002:int' has no meaning here",
    "!!timestamp x": "1: the tag 'tag:yaml.org,2002:timestamp' has no meaning here",
    "!<tag:yaml.org,2002:float> 1:30": "1: the tag 'tag:yaml.org,2002:float' has no meaning here",
    "1_000": "1: '1_000' is not a number",
    "._1": "1: '._1' is not a number",
    "9" * 5000: f"1: {'9' * 40!r} is not a number",
    "0x" + "f" * 5000: f"1: '0x{'f' * 38}' is not a number",
    "x\nb: \x1b": "2: has the character '\\x1b'",
    "{[1]: 2}": "1: a key is no word",
    "*x": "1: found undefined alias 'x'",
    "&a {b: *a}": "1: *a holds itself",
}


@pytest.fixture
def read(tmp_path):
    """The function that reads a text as YAML."""

    def read(text):
        (tmp_path / "lab.yaml").write_text(text, encoding="utf-8")
        data, lines, problems = read_yaml(tmp_path / "lab.yaml")
        return data, lines, [str(each).replace(f"{tmp_path}/", "") for each in problems]

    return read


@pytest.mark.parametrize("written", MEANT)
def test_a_value_is_what_it_looks_like(read, written):
    data, _, problems = read(f"a: {written}\n")
    assert (data, problems) == ({"a": MEANT[written]}, [])
    assert type(data["a"]) is type(MEANT[written])


@pytest.mark.parametrize("written", REFUSED)
def test_what_has_no_plain_value_is_refused_with_its_line(read, written):
    data, _, (problem,) = read(f"a: {written}\n")
    assert data is None
    assert problem.startswith(f"lab.yaml:{REFUSED[written]}; ")


def test_a_decimal_comma_in_braces_is_named_and_cuts_no_number_in_two(read):
    data, lines, problems = read("a: {b: 1,05, c: -0,5,\n d: 7, e: {f: 2,5}}\n")
    assert data == {"a": {"b": 1.05, "c": -0.5, "d": 7, "e": {"f": 2.5}}}
    assert list(lines) == [("a",), ("a", "b"), ("a", "c"), ("a", "d"), ("a", "e"), ("a", "e", "f")]
    assert problems == [
        "lab.yaml:1: a.b: 1,05 has a decimal comma; write 1.05",
        "lab.yaml:1: a.c: -0,5 has a decimal comma; write -0.5",
        "lab.yaml:2: a.e.f: 2,5 has a decimal comma; write 2.5",
    ]


def test_keys_are_words_and_have_their_lines(read):
    data, lines, problems = read("a:\n  017: 1\n\n  no: &x [2, 3]\nb: *x\n")
    assert data == {"a": {"017": 1, "no": [2, 3]}, "b": [2, 3]}
    assert problems == []
    assert lines == {
        ("a",): 1,
        ("a", "017"): 2,
        ("a", "no"): 4,
        ("a", "no", "0"): 4,
        ("a", "no", "1"): 4,
        ("b",): 5,
        ("b", "0"): 4,
        ("b", "1"): 4,
    }


def bomb(step):
    """Nine aliases of nine aliases, eight times: a few hundred bytes that stand for 43 million values."""
    names = "abcdefghi"
    lines = [
        step.format(one=one, nine=",".join([f"*{other}"] * 9))
        for one, other in zip(names[1:], names, strict=False)
    ]
    return "a: &a {x: 1}\n" + "\n".join(lines) + "\n"


WORK = {
    "aliases": bomb("{one}: &{one} [{nine}]"),
    "merged groups": bomb("{one}: &{one} {{<<: [{nine}]}}"),
    "brackets": "[" * YAML_BYTES,
    "braces": "{a: " * (YAML_BYTES // 4),
    "values": "a: [" + "1," * (YAML_BYTES // 2 - 2),
    "lines": "a:\n" + "- 1\n" * (YAML_BYTES // 4 - 1),
    "escapes": 'a: "' + "\\x41" * (YAML_BYTES // 4 - 2) + '"',
    "blank lines": "\n" * YAML_BYTES,
    "bytes": "a: " + "x" * YAML_BYTES,
    "directives": "%a\n" * (YAML_BYTES // 3),
}


@pytest.mark.parametrize("work", WORK)
@pytest.mark.slow
def test_the_work_that_a_file_may_ask_for_is_bounded(read, work):
    began, held = time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    data, _, problems = read(WORK[work])
    assert (data is None) == bool(problems)
    assert time.process_time() - began < 60  # of some seconds: work that grows as the square takes hours
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - held < 1e6  # kB


def test_as_many_values_as_a_large_campaign_needs_are_read(read):
    blocks = "".join(
        f"  block{n}: {{height_m: 0.3, width_m: 0.07, mass_kg: 5, label: Block {n}}}\n" for n in range(3000)
    )
    data, _, problems = read(f"blocks:\n{blocks}")
    assert problems == []
    assert len(data["blocks"]) == 3000
    _, _, (problem,) = read(f"a: [{'1,' * YAML_NODES}]")
    assert problem == (
        "lab.yaml:1: more than 50000 keys and values; split it into several campaigns; write aliases out"
    )
