# The figures that a campaign can have, by the name of their module in freerock.figures, whose `FIGURE` says title,
# caption and what it reads; {block} stands for one figure of each block. `figures` of the campaign says which are drawn;
# any other by its name: snakemake results/<campaign>/figures/backbone.pdf.

FIGURES = [
    "foundation_effect",
    "models_{block}",
    "restitution",
    "parameters",
    "misfit_map",
    "predictions",
    "backbone",
    "energy",
    "phase_portrait",
    "residuals_{block}",
    "evidence",
    "budget",
    "parts",
    "pulls",
]


rule figure:
    input:
        unpack(figure_files),
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
        figure="|".join(line.format(block=r"\w+") for line in FIGURES),
    conda:
        "../envs/freerock.yaml"
    params:
        code=lambda w: code("figure", f"freerock.figures.{figure_module(w)}"),
        module=figure_module,
        settings=figure_settings,
        caption=lambda w: figure_of(w)[0]["caption"],
    message:
        "{wildcards.campaign}: figure {wildcards.figure}"
    script:
        "../scripts/figure.py"


# For another target than the double column, each with its style file in src/freerock/figures. Asked for by
# `figures_for` of the campaign, or by name: snakemake results/<campaign>/figures/slide/misfit_map.pdf
use rule figure as figure_for_target with:
    input:
        unpack(figure_files),
        again=again("figure_for_target"),
    output:
        pdf="results/{campaign}/figures/{target}/{figure}.pdf",
        png="results/{campaign}/figures/{target}/{figure}.png",
        data="results/{campaign}/figures/{target}/{figure}.csv",
        caption="results/{campaign}/figures/{target}/{figure}.txt",
    log:
        "results/{campaign}/logs/figure_{figure}_{target}.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_{figure}_{target}.tsv"
    message:
        "{wildcards.campaign}: figure {wildcards.figure} for the {wildcards.target}"
