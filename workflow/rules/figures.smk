# The figures of a campaign: a line for each, by the name of its module in freerock.figures; {block} stands for one
# figure of each block. What a figure reads: records, fits, or tables by name; and settings of the campaign.

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
        "reads": ["runs", "restitution", "epsilon"],
        "settings": ["blocks"],
    },
    "misfit_map": {
        "title": "Misfit maps around the identified parameters",
        "caption": "How far the discrepancy rises around the identified parameters of the Hunt–Crossley law.",
        "reads": ["fits"],
        "settings": ["blocks", "debonding"],
    },
    "predictions": {
        "title": "Discrepancy with parameters of the run itself, of other runs, and of other blocks",
        "caption": "Discrepancy of each run with the parameters fitted to it, with those of the other runs of its "
        "record, and with those of another block on the same foundation.",
        "reads": ["predictions", "epsilon"],
    },
}
SETTINGS = {
    "blocks": settings.geometries,
    "debonding": lambda section: section.fits.debonding,
}


def figures_of(section):
    """Of each figure of a campaign, in the order of its report: its line and the block it is of, if of one."""
    blocks = dict.fromkeys(record.block for record in section.records)
    return {
        line.format(block=block): (line, block)
        for line in FIGURES
        for block in (blocks if "{block}" in line else [None])
    }


def figure_of(wildcards):
    """A figure's line, and the campaign's records that it is of."""
    section = campaign(wildcards)
    line, block = figures_of(section)[wildcards.figure]
    return FIGURES[line], [each for each in section.records if block in (None, each.block)]


def figure_module(wildcards):
    return figures_of(campaign(wildcards))[wildcards.figure][0].partition("_{")[0]


def figure_files(wildcards):
    """Input function: what a figure reads, by name."""
    line, records = figure_of(wildcards)
    folder = f"results/{wildcards.campaign}"
    return {
        name: (
            [f"{folder}/{name}/{each.test}.nc" for each in records]
            if name in ("records", "fits")
            else f"{folder}/tables/{name}.csv"
        )
        for name in line["reads"]
    }


def figure_settings(wildcards):
    """What a figure needs to know of a campaign. Scenes: what stood on what in each test, to be compared."""
    section = campaign(wildcards)
    line, records = figure_of(wildcards)
    known = {"origin": section.origin, "labels": settings.labels(section)}
    if {"records", "fits"} & {*line["reads"]}:
        known["scenes"] = [f"{each.block} on {each.foundation}" for each in records]
    return known | {name: SETTINGS[name](section) for name in line.get("settings", ())}


def figure_title(campaign, figure):
    section = CAMPAIGNS[campaign]
    line, block = figures_of(section)[figure]
    return FIGURES[line]["title"].format(block=block and section.blocks[block].label)


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
