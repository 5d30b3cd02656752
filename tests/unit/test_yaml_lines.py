"""YAML: values are what they look like."""

import pytest

from freerock.config.yaml_lines import read_yaml

MEANT = {
    "017": 17,
    "08": 8,
    "0o17": 15,
    "0x1F": 31,
    "0b11": 3,
    "1_000": 1000,
    "1e3": 1000.0,
    "6.77e+6": 6.77e6,
    ".5": 0.5,
    ".5e3": 500.0,
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
    "'5'": "5",
}
REFUSED = {
    "{[1]: 2}": "1: a key is no word",
    "*x": "1: found undefined alias 'x'",
    "[1, 2": "1: expected ',' or ']', but got '<stream end>'",
    "{b: {c: 1}\nd: 2": "1: expected ',' or '}', but got '<scalar>'",
    "[{b: 1},\n  {c: 1, d: [2}\n]": "2: expected ',' or ']', but got '}'",
    "'x\nb: 2": "1: found unexpected end of stream",
    "\n  b: 1\n\tc: 2": "3: found character '\\t' that cannot start any token",
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
