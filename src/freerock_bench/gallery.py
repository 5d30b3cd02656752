"""The figures of a report for the documentation: pictures of the shipped records, made by the workflow.

    snakemake --config campaigns=palermo_virtual
    python -m freerock_bench.gallery

writes docs/images/report_NAME.png of each figure that a report has by default. The site's gallery shows them
with the sentences on how to read them, which stand beside the captions.
"""

from pathlib import Path

from PIL import Image

from freerock.config.keys_of_campaign import CampaignFile
from freerock.errors import FreerockError
from freerock.figures.declared import declared

ROOT = Path(__file__).parents[2]
FIGURES = ROOT / "results/palermo_virtual/figures"
IMAGES = ROOT / "docs/images"
COLOURS = 32


def readings() -> dict[str, dict[str, str]]:
    """Title and how to read it, of each default figure of a report that says so, by name."""
    names = CampaignFile.model_fields["figures"].default
    return {name: declared(f"freerock.figures.{name}") for name in names}


def main() -> None:
    """Write the pictures."""
    for name in readings():
        file = FIGURES / f"{name}.png"
        if not file.exists():
            remedy = "run snakemake --config campaigns=palermo_virtual first"
            raise SystemExit(str(FreerockError(str(file), "no such figure", remedy)))
        with Image.open(file) as picture:
            few = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
            few.save(IMAGES / f"report_{name}.png", "png", optimize=True)


if __name__ == "__main__":
    main()
