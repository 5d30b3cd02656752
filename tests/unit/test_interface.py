"""Version, metadata and dependencies agree wherever they are stated."""

from importlib.metadata import version
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]


def test_metadata_agree():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_bytes())
    conda = (ROOT / "conda/meta.yaml").read_text(encoding="utf-8")
    built = f'{{% set version = "{version("freerock")}" %}}'
    assert cited["version"] == version("freerock") and built in conda


def test_the_recipe_requires_what_the_package_does():
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    recipe = (ROOT / "conda/meta.yaml").read_text(encoding="utf-8")
    recipe = recipe.partition("  run:\n")[2].partition("\ntest")[0]
    conda = {line.split()[1] for line in recipe.splitlines() if line.strip()}
    names = {"matplotlib": "matplotlib-base", "snakemake": "snakemake-minimal"}
    required = {each.split(">")[0].split("[")[0].lower() for each in project["dependencies"]}
    assert conda == {names.get(each, each) for each in required} | {"python"}
