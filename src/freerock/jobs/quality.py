"""Quality pages of one record."""

from pathlib import Path

from freerock.figures import quality
from freerock.figures.style import save
from freerock.products.netcdf import open_fits, open_record


def make_pages(
    record_file: str | Path, fits_file: str | Path, stem: str | Path, labels=None, reason: str = ""
) -> None:
    """Write a page per run as `stem`.pdf and .png, the numbers drawn as .csv; with a reason, only that."""
    record = open_record(record_file)
    drawn = (
        quality.failed(record, labels, reason)
        if reason
        else quality.draw(record, open_fits(fits_file), labels)
    )
    save(*drawn, stem, record.attrs["origin"], pdf_fonts=3)
