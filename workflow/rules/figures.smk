"""Figures of a campaign: modules of freerock.figures; captions.toml says title, caption and what they read.

`figures` of the campaign says which the report has; any other is drawn by its name.
"""


rule figure:
    input:
        unpack(figure_files),
    output:
        pdf="results/{campaign}/figures/{figure}.pdf",
        png=report(
            "results/{campaign}/figures/{figure}.png",
            caption="../report/figure.rst",
            category="{campaign}",
            subcategory="Figures",
            labels={"figure": "{figure}"},
        ),
        data="results/{campaign}/figures/{figure}.csv",
        caption="results/{campaign}/figures/{figure}.txt",
    log:
        "results/{campaign}/logs/figure_{figure}.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_{figure}.tsv"
    conda:
        "../envs/freerock.yaml"
    params:
        code=lambda w: code("figure", f"freerock.figures.{w.figure}"),
        settings=lambda w: settings.figure_settings(campaign(w), declared_of(w)),
    message:
        "{wildcards.campaign}: figure {wildcards.figure}"
    script:
        "../scripts/figure.py"
