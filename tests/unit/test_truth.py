"""truth.json: what can't be true is refused in one line."""

import json

import pytest

from freerock.errors import FreerockError
from freerock.virtual_lab.truth import read_truth, write_truth

TRUTH = {"one": {"model": "winkler", "runs": [{"k": 1e6, "c": 1e3}, {"k": 2e6, "c": 2e3}]}}


def test_truth_is_read_as_it_was_written(tmp_path):
    write_truth(tmp_path, TRUTH)
    truth = read_truth(tmp_path / "truth.json")
    assert truth == {
        ("one", run, "winkler", name): value
        for run, one in enumerate(TRUTH["one"]["runs"], 1)
        for name, value in one.items()
    }


def changed(**run):
    return json.dumps({"one": {"model": "winkler", "runs": [{"k": 1e6, "c": 1e3} | run]}})


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("{", "is not JSON (Expecting property name enclosed in double quotes"),
        (changed(k=None), "one: does not hold the model and its parameters run by run (TypeError"),
        ('{"one": {"model": "winkler", "runs": 5}}', "one: does not hold the model and its parameters"),
        ("\xff", "is not JSON ('utf-8' codec can't decode"),
    ],
)
def test_what_is_no_truth_is_refused(tmp_path, text, what):
    (tmp_path / "truth.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(FreerockError) as error:
        read_truth(tmp_path / "truth.json")
    line = str(error.value)
    assert line.replace(f"{tmp_path}/truth.json: ", "").startswith(what), line
    assert line.endswith("; restore the file, or remove the key truth")
