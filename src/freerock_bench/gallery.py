"""The figures of a report for the documentation: pictures of the shipped records, and Python that draws them.

    snakemake --config campaigns=palermo_virtual
    python -m freerock_bench.gallery

writes docs/images/report_NAME.png of each figure. The site's gallery shows them with captions and programs.
"""

from pathlib import Path

from PIL import Image

from freerock.errors import FreerockError
from freerock.figures.declared import FIGURES, declared

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "results/palermo_virtual/figures"
IMAGES = ROOT / "docs/images"
COLOURS = 32
OF_CAMPAIGN = {"blocks": "{name: Block(**each) for name, each in geometries(campaign).items()}"}
OF_CAMPAIGN |= {"set_ups": "set_ups(campaign)"}


def program(name: str) -> str:
    """Python that draws a figure from the folder of results of a campaign."""
    reads = declared(f"freerock.figures.{name}")["reads"]
    tables = [each for each in reads if each not in ("records", "fits", *OF_CAMPAIGN)]
    lines = ["import pandas as pd"] * bool(tables)
    lines += ["from freerock.config.campaign import load_config"] * bool({*reads} & {*OF_CAMPAIGN})
    steps = [
        each
        for each, needed in (("geometries", "blocks" in reads), ("set_ups", "set_ups" in reads))
        if needed
    ]
    lines += [f"from freerock.config.step_settings import {', '.join(steps)}"] * bool(steps)
    lines += [f"from freerock.figures.{name} import draw"]
    lines += ["from freerock.models.block import Block"] * ("blocks" in reads)
    opened = [
        f"open_{each.removesuffix('s') if each == 'records' else each}"
        for each in reads
        if each in ("records", "fits")
    ]
    lines += [f"from freerock.products.netcdf import {', '.join(sorted(opened))}"] * bool(opened)
    lines += ["", 'name, folder = "palermo_virtual", "results/palermo_virtual"']
    if steps:
        lines += ['campaign = load_config("config/config.yaml", [name]).campaigns[name]']
    if opened:
        lines += ['tests = ["config2_marble", "config2_aerstop"]']
    for each in reads:
        if each in OF_CAMPAIGN:
            lines += [f"{each} = {OF_CAMPAIGN[each]}"]
        elif each in tables:
            lines += [f'{each} = pd.read_csv(f"{{folder}}/tables/{each}.csv", dtype={{"run": str}})']
        else:
            how = "open_record" if each == "records" else "open_fits"
            lines += [f'{each} = [{how}(f"{{folder}}/{each}/{{test}}.nc") for test in tests]']
    lines += [f'figure, numbers = draw({", ".join(reads)}, "simulated")', f'figure.savefig("{name}.png")']
    return "\n".join(lines)


def main() -> None:
    """Write the pictures."""
    for name in FIGURES:
        file = FOLDER / f"{name}.png"
        if not file.exists():
            remedy = "run snakemake --config campaigns=palermo_virtual first"
            raise SystemExit(str(FreerockError(str(file), "no such figure", remedy)))
        with Image.open(file) as picture:
            few = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
            few.save(IMAGES / f"report_{name}.png", "png", optimize=True)


if __name__ == "__main__":
    main()
