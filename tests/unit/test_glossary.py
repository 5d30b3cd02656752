"""The names in docs/glossary.md are those of the code, and all of them."""

import re
from pathlib import Path

import pandas as pd

from freerock.config.campaign import ConfigFile
from freerock.config.keys_of_campaign import CampaignFile
from freerock.config.keys_of_scene import Scene
from freerock.config.record import Record
from freerock.config.values import section_in
from freerock.models.block import Block
from freerock.models.laws import LAWS
from freerock.planning import plan, plan_total
from freerock.populations import predict, shared_foundation
from freerock.products.names import VARIABLES
from freerock.tables import columns as tables
from freerock.tables import populations, summary

GLOSSARY = Path(__file__).parents[2] / "docs/glossary.md"
HEAD = ["term", "meaning", "symbol", "config", "netCDF", "CSV", "unit"]


def names(column):
    """Names between backticks in a column of the glossary's tables."""
    found = set()
    for line in GLOSSARY.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("|") and len(cells) == len(HEAD):
            found |= set(re.findall(r"`(\w+)`", cells[HEAD.index(column)]))
    return found


def keys(model):
    """Keys of a section of the configuration and of the sections in it."""
    found = set(model.model_fields)
    for field in model.model_fields.values():
        child = section_in(field.annotation)
        found |= keys(child) if child else set()
    return found


def columns():
    """Columns of all tables."""
    parameters, epsilon = (
        pd.DataFrame(columns=names) for names in (tables.PARAMETERS_COLUMNS, tables.EPSILON_COLUMNS)
    )
    frames = [
        summary.table1([], {"block": Block(height_m=0.28, width_m=0.07, mass_kg=5.84)}),
        summary.table2(populations.populations_table(parameters), parameters),
        summary.table3(epsilon),
        summary.recovered_table(parameters, {}),
    ]
    lists = [
        tables.RUNS_COLUMNS,
        tables.PARAMETERS_COLUMNS,
        tables.EPSILON_COLUMNS,
        tables.CHOICE_COLUMNS,
        tables.RESTITUTION_COLUMNS,
        tables.RESTITUTION_COMPARISON_COLUMNS,
    ]
    lists += [
        tables.CANDIDATES_COLUMNS,
        tables.RARE_CANDIDATES_COLUMNS,
        tables.RARE_IMPACTS,
        shared_foundation.FOUNDATIONS,
        predict.PREDICTIONS,
        tables.POPULATIONS_COLUMNS,
        tables.BUDGET_COLUMNS,
        plan.COLUMNS,
        plan.RIVALS,
        tables.PARTS_COLUMNS,
        tables.PULLS_COLUMNS,
        tables.REASONS_COLUMNS,
        plan_total.BUDGET,
        plan_total.TOTALS,
        tables.RESTITUTION_LAW_COLUMNS,
    ]
    return {column for listed in [*lists, *frames] for column in listed}


def test_every_configuration_key_is_in_the_glossary_and_no_other():
    # the names of the laws are rows of `models.laws`
    declared = set().union(*map(keys, (ConfigFile, CampaignFile, Record, Scene)))
    assert names("config") == declared - set(LAWS)


def test_every_variable_is_in_the_glossary_and_no_other():
    assert names("netCDF") == set(VARIABLES)


def test_every_column_is_in_the_glossary_and_no_other():
    assert names("CSV") == columns()
