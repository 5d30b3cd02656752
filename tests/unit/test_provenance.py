import json
import os

import numpy as np

from freerock.files import sha256, write_json
from freerock.products import provenance as made
from freerock.products.provenance import provenance


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
