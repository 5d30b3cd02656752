"""Standard errors of parameters, and rivals that a run would reject, predicted before any test.

example:
  freerock plan palermo_virtual

The section `plan` of the campaign states expected parameters and choices: see config/README.md.
"""

from argparse import Namespace
from collections.abc import Callable
from pathlib import Path

from freerock.config.campaign import load_campaign
from freerock.config.step_settings import labels as labels_of


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("campaign", metavar="CAMPAIGN", help="its name or YAML file")
    add(
        "--into",
        metavar="FOLDER",
        help="folder of the tables and figures; by default results/<campaign>/plan",
    )


def run(chosen: Namespace) -> None:
    """Predict, print and draw."""
    named = chosen.campaign.endswith((".yaml", ".yml"))
    path = Path(chosen.campaign) if named else Path("config/campaigns") / f"{chosen.campaign}.yaml"
    campaign = load_campaign(path)  # refused before the numerical libraries are loaded

    from freerock.figures.plan_pages import draw, draw_rivals, draw_totals
    from freerock.figures.style import save
    from freerock.planning.plan_campaign import plan_campaign
    from freerock.tables.csvfile import write_csv
    from freerock.tables.plan_text import plan_text, rivals_text, totals_text

    found, labels = plan_campaign(campaign), labels_of(campaign)
    folder = Path(chosen.into or f"results/{campaign.name}/plan")
    pages = {
        "plan": (found.errors, draw, plan_text),
        "rivals": (found.rivals, draw_rivals, rivals_text),
        "total": (found.totals, draw_totals, totals_text),
    }
    pages = {stem: page for stem, page in pages.items() if not page[0].empty}
    for stem, (table, drawn, told) in pages.items():
        save(*drawn(table, labels), folder / stem)
        print(f"{told(table, labels)}\n")
    write_csv(found.budget, folder / "budget.csv")
    for stem in pages:
        print(f"written: {folder / stem}.csv, .pdf, .png")
    print(f"written: {folder / 'budget.csv'}")
