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
    save(*draw(found.errors, labels), folder / "plan")
    print(plan_text(found.errors, labels))
    written = ["plan"]
    if not found.rivals.empty:
        save(*draw_rivals(found.rivals, labels), folder / "rivals")
        print(f"\n{rivals_text(found.rivals, labels)}")
        written.append("rivals")
    write_csv(found.budget, folder / "budget.csv")
    if not found.totals.empty:
        save(*draw_totals(found.totals, labels), folder / "total")
        print(f"\n{totals_text(found.totals, labels)}")
        written.append("total")
    print()
    for stem in written:
        print(f"written: {folder / stem}.csv, .pdf, .png")
    print(f"written: {folder / 'budget.csv'}")
