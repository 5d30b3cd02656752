"""The scattering campaign of the documentation can be made."""

import sys

from small_campaign import ROOT

from freerock.records.read import read_record


def test_the_scattering_campaign_is_made(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    import scattering

    monkeypatch.setattr(scattering, "BLOCKS", {"config3": scattering.BLOCKS["config3"]})
    monkeypatch.setattr(scattering, "TABLE_2", {"aerstop": scattering.TABLE_2["aerstop"]})
    scattering.main(tmp_path)
    (file,) = (tmp_path / "raw/scattering").glob("*.csv")
    volts = read_record(file, "laser")["laser"]
    assert (tmp_path / "config/campaigns/scattering.csv").read_text().count("\n") == 2
    assert len(volts) > 10_000 and 0.5 < abs(volts).max() <= 10.5
    del sys.modules["scattering"]
