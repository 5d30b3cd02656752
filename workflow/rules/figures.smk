# The figures of a campaign: a line for each, by the name of its module in freerock.figures; {block} stands for one
# figure of each block. What a figure reads: records, fits, maps (of the misfit), tables by name, the blocks.

FIGURES = {
    "foundation_effect": {
        "title": "Effect of the foundation on the measured rotation",
        "caption": "Rotation of each block after its release, on each foundation (Spanos et al. 2017, figure 2).",
        "reads": ["records"],
    },
    "models_{block}": {
        "title": "Measured rotation of {block} and the models fitted to it",
        "caption": "Rotation and models, residuals below (Spanos et al. 2017, figure 3).",
        "reads": ["fits"],
    },
    "restitution": {
        "title": "Restitution of each impact",
        "caption": "Restitution of each impact, from the peaks before and after it; dotted, a rigid block on a rigid "
        "base. Fits that failed are left out.",
        "reads": ["runs", "restitution", "epsilon", "blocks"],
    },
    "misfit_map": {
        "title": "Misfit maps around the identified parameters",
        "caption": "How far the discrepancy rises around the identified parameters of the Hunt–Crossley law.",
        "reads": ["maps"],
    },
    "predictions": {
        "title": "Discrepancy with parameters of the run itself, of other runs, and of other blocks",
        "caption": "Discrepancy of each run with the parameters fitted to it, with those of the other runs of its "
        "record, and with those of another block on the same foundation.",
        "reads": ["predictions", "epsilon"],
    },
}


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
            labels=lambda w: {"figure": figure_title(w.campaign, w.figure)},
        ),
        data="results/{campaign}/figures/{figure}.csv",
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
    output:
        pdf="results/{campaign}/figures/{target}/{figure}.pdf",
        png="results/{campaign}/figures/{target}/{figure}.png",
        data="results/{campaign}/figures/{target}/{figure}.csv",
    log:
        "results/{campaign}/logs/figure_{figure}_{target}.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_{figure}_{target}.tsv"
    message:
        "{wildcards.campaign}: figure {wildcards.figure} for the {wildcards.target}"
