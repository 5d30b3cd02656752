import json
import os

import numpy as np
import xarray as xr

from freerock.files import sha256, write_json
from freerock.products import provenance as made
from freerock.products.provenance import other_software, provenance


def test_provenance_names_inputs_config_and_versions(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.tdms").write_bytes(b"volts")
    made_by = provenance(["a.tdms"], {"window_s": 0.25})
    assert made_by["inputs"] == {"a.tdms": sha256("a.tdms")}
    assert made_by["config"] == {"window_s": 0.25}
    assert made_by["software"]["numpy"] == np.__version__
    assert set(made_by["software"]) == {"python", *made.SOFTWARE}
    assert made_by["git"]
    write_json("provenance.json", made_by)
    assert json.loads((tmp_path / "provenance.json").read_text()) == made_by


def test_git_state_is_unknown_without_git(monkeypatch):
    monkeypatch.setitem(os.environ, "PATH", "")
    monkeypatch.setattr(made, "_git_state", made._git_state.__wrapped__)
    assert provenance([], {})["git"] == "unknown"


def test_other_versions_are_told_with_what_they_made():
    now = {"python": "3.11.7", "numpy": "2.0"}
    trees = {
        "records/a": now,
        "fits/a": now | {"numpy": "1.26"},
        "fits/b": now | {"numpy": "1.26"},
        "records/b": {"python": "3.11.7"},
    }
    datasets = {
        name: xr.DataTree(xr.Dataset(attrs={"provenance": json.dumps({"software": software})}))
        for name, software in trees.items()
    }
    datasets["records/failed"] = xr.DataTree(xr.Dataset())
    assert other_software(datasets, now) == [
        {"software": {"numpy": "1.26"}, "datasets": ["fits/a", "fits/b"]},
        {"software": {"numpy": "none"}, "datasets": ["records/b"]},
    ]
    assert other_software({"records/a": datasets["records/a"]}, now) == []
