"""The figures of a report for the documentation: pictures of the shipped records, and Python that draws them.

    snakemake --config campaigns=palermo_virtual
    python -m freerock_bench.gallery

writes docs/images/report_NAME.png of each figure. The site's gallery shows them with captions and programs.
"""

from pathlib import Path

from PIL import Image

from freerock.figures.listed import FIGURES, entry_of

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "results/palermo_virtual/figures"
IMAGES = ROOT / "docs/images"
COLOURS = 32
OF_SCENES = '{0} = [results.{0}[f"config2_{{each}}"] for each in ("marble", "aerstop")]'
BLOCKS = "blocks = {name: freerock.Block(**each) for name, each in settings.geometries(campaign).items()}"
MADE = {each: OF_SCENES.format(each) for each in ("records", "fits")}
MADE |= {"blocks": BLOCKS, "set_ups": "set_ups = settings.set_ups(campaign)"}


def program(name: str) -> str:
    """Python that draws a figure from the folder of results of a campaign."""
    reads = entry_of(name)["reads"]
    given = [each if each in MADE else f'tables["{each}"]' for each in reads]
    lines, configured = ["import freerock"], bool({"blocks", "set_ups"} & {*reads})
    lines += ["from freerock.config import step_settings as settings"] * configured
    lines += [f"from freerock.figures.{name} import draw", ""]
    lines += ['results = freerock.open_results("results/palermo_virtual")'] * (name != "set_up")
    lines += ["tables = results.tables"] * (given != reads)
    lines += ['campaign = freerock.load_campaign("config/campaigns/palermo_virtual.yaml")'] * configured
    lines += [MADE[each] for each in reads if each in MADE]
    lines += [f'figure, numbers = draw({", ".join(given)}, "simulated")', f'figure.savefig("{name}.png")']
    return "\n".join(lines)


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
