"""The figures of a report for the documentation: pictures of the shipped records, and Python that draws them.

    snakemake --config campaigns=palermo_virtual
    python -m freerock_bench.gallery

writes docs/images/report_NAME.png of each figure. The site's gallery shows them with captions and programs.
"""

from pathlib import Path

from PIL import Image

from freerock.figures.declared import FIGURES, declared

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "results/palermo_virtual/figures"
IMAGES = ROOT / "docs/images"
COLOURS = 32
OPENED = '{0} = [freerock.open_{1}(f"{{folder}}/{0}/config2_{{each}}.nc") for each in ("marble", "aerstop")]'
MADE = {"records": OPENED.format("records", "record"), "fits": OPENED.format("fits", "fits")}
MADE["blocks"] = (
    "blocks = {name: freerock.Block(**each) for name, each in settings.geometries(campaign).items()}"
)
MADE["set_ups"] = "set_ups = settings.set_ups(campaign)"


def program(name: str) -> str:
    """Python that draws a figure from the folder of results of a campaign."""
    reads = declared(f"freerock.figures.{name}")["reads"]
    tables, made = [each for each in reads if each not in MADE], [each for each in reads if each in MADE]
    lines = ["import pandas as pd"] * bool(tables) + ["import freerock"] * bool(made)
    if configured := {"blocks", "set_ups"} & {*reads}:
        lines.append("from freerock.config import step_settings as settings")
    lines += [f"from freerock.figures.{name} import draw", "", 'folder = "results/palermo_virtual"']
    if configured:
        lines.append('campaign = freerock.load_campaign("config/campaigns/palermo_virtual.yaml")')
    lines += [MADE[each] for each in made]
    if tables:
        read = 'pd.read_csv(f"{folder}/tables/{name}.csv", dtype={"run": str})'
        lines.append(f"tables = [{read} for name in {tables}]")
    given = dict.fromkeys("*tables" if each in tables else each for each in reads)
    return "\n".join(
        [*lines, f'figure, numbers = draw({", ".join(given)}, "simulated")', f'figure.savefig("{name}.png")']
    )


def in_few_colours(file: Path, target: Path) -> None:
    """Write a picture as a small PNG, the same bytes each time."""
    with Image.open(file) as picture:
        few = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
        few.save(target, "png", optimize=True)


def main() -> None:
    """Write the pictures."""
    for name in FIGURES:
        in_few_colours(FOLDER / f"{name}.png", IMAGES / f"report_{name}.png")


if __name__ == "__main__":
    main()
