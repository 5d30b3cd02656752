"""How well one run will tell each parameter, predicted before any test.

example:
  freerock plan palermo_virtual

The section `plan` of the campaign states expected parameters and choices: see config/README.md.
"""

from argparse import Namespace
from collections.abc import Callable
from pathlib import Path

from freerock.config.campaign import load_campaign
from freerock.config.step_settings import labels

EXACT = (
    "Impacts are taken as exact. Where they scatter by 1 %, as in palermo_virtual, u of k was 1.1 to 2.3 "
    "times the total of this table, of damping 1.5 to 6 times."
)


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("campaign", metavar="CAMPAIGN", help="its name or YAML file")
    add("--into", metavar="FILE", help="the table; by default results/<campaign>/plan.csv")


def run(chosen: Namespace) -> None:
    """Predict, print and write."""
    named = chosen.campaign.endswith((".yaml", ".yml"))
    path = Path(chosen.campaign) if named else Path("config/campaigns") / f"{chosen.campaign}.yaml"
    campaign = load_campaign(path)  # refused before the numerical libraries are loaded

    from freerock.planning.plan import plan
    from freerock.tables.csvfile import write_csv
    from freerock.tables.plan_text import plan_text

    found, into = plan(campaign), Path(chosen.into or f"results/{campaign.name}/plan.csv")
    write_csv(found, into)
    print(f"{plan_text(found, labels(campaign))}\n\n{EXACT}\nwritten: {into}")
