"""Quality control of some records, a page per run."""

from freerock.jobs.ledger import at_work

with at_work(snakemake, __file__):
    from freerock.jobs.each_record import make_each
    from freerock.jobs.quality_pages import make_pages

    pages = dict(zip(snakemake.params.tests, snakemake.output.png, strict=True))
    inputs = dict(zip(pages, zip(snakemake.input.records, snakemake.input.fits, strict=True), strict=True))

    def make(test, reason=""):
        make_pages(*inputs[test], pages[test].removesuffix(".png"), snakemake.params.labels, reason)

    make_each(list(pages), make, make)
