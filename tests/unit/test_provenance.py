import json

import numpy as np
import pytest

from freerock.errors import FreerockError
from freerock.files import sha256, write_json
from freerock.products import provenance as made
from freerock.products.provenance import git_state, made_by, other_software, provenance


def test_provenance_names_inputs_config_and_versions(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.tdms").write_bytes(b"volts")
    found = provenance(["a.tdms"], {"window_s": 0.25})
    assert found["inputs"] == {"a.tdms": sha256("a.tdms")}
    assert found["config"] == {"window_s": 0.25}
    assert found["software"]["numpy"] == np.__version__
    assert set(found["software"]) == {"python", *made.SOFTWARE}
    assert git_state()
    write_json("provenance.json", found)
    assert json.loads((tmp_path / "provenance.json").read_text()) == found


def test_other_versions_are_told_with_what_they_made():
    now = {"python": "3.11.7", "numpy": "2.0"}
    versions = {
        "records/a": now,
        "fits/a": now | {"numpy": "1.26"},
        "fits/b": now | {"numpy": "1.26"},
        "records/b": {"python": "3.11.7"},
    }
    datasets = {name: {"software": software} for name, software in versions.items()} | {"records/failed": {}}
    assert other_software(datasets, now) == [
        {"software": {"numpy": "1.26"}, "datasets": ["fits/a", "fits/b"]},
        {"software": {"numpy": "none"}, "datasets": ["records/b"]},
    ]
    assert other_software({"records/a": datasets["records/a"]}, now) == []
    older = {"python": "3.10", "numpy": "1.26"}
    made_by = {"a": {"software": older}, "b": {"software": dict(reversed(older.items()))}}
    assert [each["datasets"] for each in other_software(made_by, now)] == [["a", "b"]]


def test_a_product_that_is_missing_or_damaged_is_named(tmp_path):
    with pytest.raises(FreerockError, match="there is no such file"):
        made_by(tmp_path / "a.nc")
    (tmp_path / "a.nc").write_bytes(b"no product")
    with pytest.raises(FreerockError, match="is not a readable netCDF file"):
        made_by(tmp_path / "a.nc")
