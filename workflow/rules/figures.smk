"""Figures of a campaign: modules of freerock.figures; captions.toml says title, caption and what they read."""


rule figures:
    input:
        records=of_tests("records/{test}.nc"),
        fits=of_tests("fits/{test}.nc"),
        tables=csv_tables(*drawn_tables()),
    output:
        png=[
            report(
                f"results/{{campaign}}/figures/{name}.png",
                caption="../report/figure.rst",
                category="{campaign}",
                subcategory="Figures",
                labels={"figure": name},
            )
            for name in FIGURES
        ],
        pdf=of_figures("pdf"),
        data=of_figures("csv"),
        captions=of_figures("txt"),
    log:
        "results/{campaign}/logs/figures.log",
    priority: 1
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("figures"),
        settings=of_campaign(settings.figure_settings),
    message:
        "{wildcards.campaign}: figures"
    script:
        "../scripts/figures.py"
