"""The virtual campaign, planned with little to compute."""

from pathlib import Path

import yaml

from freerock.config.campaign import load_campaign

PALERMO = Path(__file__).parents[2] / "config/campaigns/palermo_virtual.yaml"


def campaign(tmp_path, change=lambda keys: None):
    """The virtual campaign planned for one rate and angle, with its keys changed."""
    keys = yaml.safe_load(PALERMO.read_text(encoding="utf-8"))
    keys["plan"] |= {"sampling_rates_hz": [500], "durations_s": [2], "release_angles_deg": {}}
    change(keys)
    (tmp_path / "lab.yaml").write_text(yaml.safe_dump(keys), encoding="utf-8")
    (tmp_path / "lab.csv").write_text(PALERMO.with_suffix(".csv").read_text(encoding="utf-8"))
    return load_campaign(tmp_path / "lab.yaml")
