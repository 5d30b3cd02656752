"""Quality pages of one record."""

from pathlib import Path

from freerock.figures import quality
from freerock.figures.style import Labels, save
from freerock.products.netcdf import open_fits, open_record


def make_quality(
    record_file: str | Path, fits_file: str | Path, stem: str | Path, labels: Labels = None, reason: str = ""
) -> None:
    """Write a page per run as `stem`.pdf and .png, the numbers drawn as .csv.

    Parameters
    ----------
    record_file, fits_file : path
        Datasets of a record and of its fits.
    stem : path
        Files to write, without suffix.
    labels : mapping of str to str, optional
        Printed names of blocks and foundations.
    reason : str
        Why the record can't be drawn: then there is one page with the reason.
    """
    record = open_record(record_file)
    if reason:
        drawn = quality.failed(record, labels, reason)
    else:
        drawn = quality.draw(record, open_fits(fits_file, only=quality.OF_FITS), labels)
    save(*drawn, stem, record.attrs["origin"])
