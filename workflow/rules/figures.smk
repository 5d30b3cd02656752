"""Figures of a campaign: modules of freerock.figures; figures.toml says title, caption and what they read."""


rule figure:
    input:
        unpack(figure_files),
    output:
        png=report(
            "results/{campaign}/figures/{figure}.png",
            caption="../report/figure.rst",
            category="{campaign}",
            subcategory="Figures",
            labels={"figure": "{figure}"},
        ),
        pdf="results/{campaign}/figures/{figure}.pdf",
        data="results/{campaign}/figures/{figure}.csv",
        caption="results/{campaign}/figures/{figure}.txt",
    log:
        "results/{campaign}/logs/figure_{figure}.log",
    priority: 1
    conda:
        "../envs/freerock.yaml"
    params:
        code=lambda w: code("figure", f"freerock.figures.{w.figure}"),
        settings=of_campaign(settings.figure_settings),
    message:
        "{wildcards.campaign}: figure {wildcards.figure}"
    script:
        "../scripts/figure.py"
