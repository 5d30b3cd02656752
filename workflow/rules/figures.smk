# The figures that a campaign can have: a line for each, by the name of its module in freerock.figures; {block} stands
# for one figure of each block. `figures` of the campaign says which are drawn; any other by its name:
# snakemake results/<campaign>/figures/backbone.pdf. What a figure reads: records, fits, maps (of the misfit), tables by
# name, the blocks. Title and caption are those of its .txt; which runs are drawn, the module adds.

FIGURES = {
    "foundation_effect": {
        "title": "Effect of the foundation on the rotation",
        "caption": "Rotation θ of each block after its release, on each foundation, as in figure 2 of Spanos et al. 2017.",
        "reads": ["records"],
    },
    "models_{block}": {
        "title": "{Measured} rotation of {block} and the models fitted to it",
        "caption": "Rotation θ and the models fitted to it, as in figure 3 of Spanos et al. 2017; below, modelled minus "
        "recorded rotation over σ, the standard deviation of one sample of θ at rest. The grey band is ±1.96 σ: a "
        "model that leaves nothing but white noise is inside it for 95 % of the samples. The scale is linear up to ±3 σ "
        "and logarithmic beyond. ε_θ is the relative mean square discrepancy.",
        "reads": ["fits", "runs"],
    },
    "restitution": {
        "title": "Restitution of each impact",
        "caption": "Restitution r of each impact, from the peaks before and after it, against the impact speed, that "
        "of the far corner of a rigid block that falls from the peak before it. Bars: one standard error. Shaded: where 95 % of the recorded impacts "
        "of like speed lie, by a local line and the scatter about it. Dashed, where r is not a constant with 95 % certainty: the mean "
        "of the straight lines through the recorded impacts of each run. Dotted: a rigid block on a rigid base (Housner 1963). Impacts "
        "of failed fits are left out.",
        "reads": ["runs", "restitution", "epsilon", "blocks"],
    },
    "parameters": {
        "title": "Identified parameters, run by run",
        "caption": "Each run with its 95 % interval, by its noise (within the sign where none is seen; open where the choice of a model rejects the law for that "
        "run). Diamond and square: mean of a record, and of the records of a foundation, with the 95 % interval of its total "
        "uncertainty, which holds scatter, noise and what is known of block, sensor and clock. Shaded: where the next run or "
        "record lies with 95 %. τ: standard deviation between them without their noise, in per cent of the mean.",
        "reads": ["parameters", "populations", "choice"],
    },
    "misfit_map": {
        "title": "Misfit maps around the identified parameters",
        "caption": "How far the discrepancy ε_θ of the Hunt–Crossley law rises around the parameters identified on the first "
        "run of each record, in per cent; full dot, those parameters; open dots, the parameters identified on its other runs. Law rejected: the choice of a model rejects it for the first run, and the "
        "parameters describe the fit, not the foundation.",
        "reads": ["maps", "choice"],
    },
    "predictions": {
        "title": "Discrepancy with parameters of the run itself, of other runs, and of other blocks",
        "caption": "Discrepancy ε_θ of each run with the parameters fitted to it, with those of the other runs of its "
        "record, and with those of another block on the same foundation. Failed fits predict nothing.",
        "reads": ["predictions", "epsilon"],
    },
    "backbone": {
        "title": "Period against amplitude",
        "caption": "Twice the time between two impacts against the largest |θ| between them. Dotted: a rigid block (Housner "
        "1963), whose period does not depend on r and goes to zero with its amplitude.",
        "reads": ["runs", "restitution", "epsilon", "blocks"],
    },
    "energy": {
        "title": "Energy through a run, and what each impact takes of it",
        "caption": "Left, energy above rest before each impact, that of a rigid block at the peak of |θ| (Housner 1963). Right, "
        "share of it that the impact takes, 1 − r²; bars, one standard error. Signs: the record; lines: the model that the "
        "choice names, or else that of the least ε_θ.",
        "reads": ["runs", "restitution", "epsilon", "blocks"],
    },
    "phase_portrait": {
        "title": "Phase portrait",
        "caption": "Angular rate against rotation, from parabolas over 0.02 s, of the record and of the model that the choice "
        "names, or else of the fit with the least ε_θ.",
        "reads": ["fits", "epsilon"],
    },
    "residuals_{block}": {
        "title": "Residuals of {block} against the noise at rest",
        "caption": "Left, power spectral density of modelled minus recorded rotation, with sine tapers, means over a sixth of an "
        "octave, and of the noise at rest of the same record. Right, autocorrelation of the residual; the band holds 95 % "
        "of that of white noise.",
        "reads": ["fits", "records"],
    },
    "evidence": {
        "title": "Evidence for each candidate law",
        "caption": "For each run and candidate the power of what its fit leaves over that of the noise at rest, in the "
        "frequency band that tells most; 1 (dotted) is noise. Signs say what the choice of a model made of it.",
        "reads": ["choice"],
    },
    "budget": {
        "title": "Uncertainty budget of the identified parameters",
        "caption": "Share of each input in the square of the total standard uncertainty u of each mean (k = 1, in per cent of "
        "the mean at the right); runs, their scatter beyond what the inputs explain.",
        "reads": ["budget", "choice"],
    },
    "parts": {
        "title": "Parameters against the fitted part of a run",
        "caption": "The parameters of the law that the choice names, fitted to each sixth of the swings of a run, over those "
        "of the whole run; release angle and instant are free in each part. Horizontal: what the part covers; vertical: 95 % by "
        "white noise. A law that holds for the whole run stays at zero.",
        "reads": ["parts", "parameters", "choice"],
    },
    "pulls": {
        "title": "Pulls of the inputs, and their impacts on the parameters",
        "caption": "Left, shift of each input by the fit of the law that the choice names, in its standard uncertainties u; bars, "
        "what remains of u after the fit. Open: the run does not see the input. Shaded: ±1 and ±2. Right, shift of each parameter where the input is held one "
        "remaining uncertainty higher and all else is fitted again, in per cent; medians of the runs.",
        "reads": ["pulls", "choice"],
    },
}


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
