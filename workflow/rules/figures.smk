# The figures that a campaign can have: modules of freerock.figures, whose `FIGURE` says title, caption and what they
# read. `figures` of the campaign says which the report has; one job draws these. Any other is drawn by its name:
# snakemake results/<campaign>/figures/backbone.pdf.

REPORTED_FIGURES = {name: section.figures for name, section in CAMPAIGNS.items() if section.figures}

for name, figures in REPORTED_FIGURES.items():

    rule:
        name:
            f"figures_{name}"
        input:
            **figure_files(name, figures),
            again=again(f"figures_{name}", name),
        output:
            pdf=[f"results/{name}/figures/{figure}.pdf" for figure in figures],
            png=[
                report(
                    f"results/{name}/figures/{figure}.png",
                    caption="../report/figure.rst",
                    category=name,
                    subcategory="Figures",
                    labels={"figure": figure_title(name, figure)},
                )
                for figure in figures
            ],
            data=[f"results/{name}/figures/{figure}.csv" for figure in figures],
            caption=[f"results/{name}/figures/{figure}.txt" for figure in figures],
        log:
            f"results/{name}/logs/figures.log",
        benchmark:
            f"results/{name}/benchmarks/figures.tsv"
        conda:
            "../envs/freerock.yaml"
        params:
            code=code("figure", *modules_of(figures)),
            figures=figure_settings(name, figures),
        message:
            f"{name}: figures"
        script:
            "../scripts/figure.py"


rule figure:
    input:
        unpack(lambda w: figure_files(w.campaign, [w.figure])),
        again=again("figure"),
    output:
        pdf="results/{campaign}/figures/{figure}.pdf",
        png=report(
            "results/{campaign}/figures/{figure}.png",
            caption="../report/figure.rst",
            category="{campaign}",
            subcategory="Figures",
            labels=lambda w: {"figure": figure_title(w.campaign, w.figure)},
        ),
        data="results/{campaign}/figures/{figure}.csv",
        caption="results/{campaign}/figures/{figure}.txt",
    log:
        "results/{campaign}/logs/figure_{figure}.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_{figure}.tsv"
    wildcard_constraints:
        # of a campaign those figures that are not in its report: a look ahead in the path
        campaign=r"(?!(?:{})\.)\w+".format(
            "|".join(f"{name}/figures/(?:{'|'.join(figures)})" for name, figures in REPORTED_FIGURES.items())
        ),
        figure="|".join(FIGURES),
    conda:
        "../envs/freerock.yaml"
    params:
        code=lambda w: code("figure", *modules_of([w.figure])),
        figures=lambda w: figure_settings(w.campaign, [w.figure]),
    message:
        "{wildcards.campaign}: figure {wildcards.figure}"
    script:
        "../scripts/figure.py"
