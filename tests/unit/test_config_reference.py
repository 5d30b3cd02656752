"""The generated reference of the keys, and the schemas for editors."""

import json
import re
from pathlib import Path

import yaml
from jsonschema import Draft202012Validator

from freerock.config.campaign import ConfigFile
from freerock.config.campaign_file import CampaignFile
from freerock.config.reference import MARK, files, json_schema

ROOT = Path(__file__).parents[2]


def test_readme_and_schemas_agree_with_the_models():
    readme = (ROOT / "config/README.md").read_text(encoding="utf-8")
    assert MARK in readme
    for name, text in files(readme).items():
        assert (ROOT / "config" / name).read_text(encoding="utf-8") == text, name


def test_shipped_files_name_their_schema_and_agree_with_it():
    shipped = [ROOT / "config/config.yaml"]
    for path in [*shipped, *(ROOT / "config/campaigns").glob("*.yaml")]:
        text = path.read_text(encoding="utf-8")
        named = re.match(r"# yaml-language-server: \$schema=(\S+)\n", text)[1]
        schema = json.loads((path.parent / named).read_text(encoding="utf-8"))
        Draft202012Validator.check_schema(schema)
        data = yaml.safe_load(text)
        assert list(Draft202012Validator(schema).iter_errors(data)) == []
        assert list(Draft202012Validator(schema).iter_errors(data | {"titel": 1})) != []


def test_every_key_is_described():
    def descriptions(schema):
        for definition in [schema, *schema.get("$defs", {}).values()]:
            for name, key in definition["properties"].items():
                yield name, key.get("description")

    models = (ConfigFile, CampaignFile)
    found = [item for model in models for item in descriptions(json_schema(model))]
    assert len(found) > 40
    assert [name for name, description in found if not description] == []
