"""Snakemake's own report of a finished campaign."""

import re
import zipfile


def test_report_zip_holds_every_product_and_loads_nothing(checkout):
    done = checkout.snakemake("--report", "report.zip")
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(checkout / "report.zip") as archive:
        names = {name.rpartition("/")[2] for name in archive.namelist()}
        page = archive.read("report/report.html").decode()
    assert {"report.html", "table2.tex", "table3.md", "restitution.png", "residuals.png"} <= names
    assert not re.search(r"""<(script|link|img)[^>]+(src|href)=["'](https?:)?//""", page)
    for told in ("Tables", "Figures", "Quality control", "Restitution of each impact", "2, parameters"):
        assert told in page
