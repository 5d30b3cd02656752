# Studies of the methods: not part of a campaign, run by `snakemake studies`, in minutes by
# `snakemake studies --config studies=small`.

from freerock.files import sha256

STUDIES = [
    "bits",
    "speed_accuracy",
    "stability",
    "success",
    "confusion",
    "kinds",
]

# What a study reads besides its code, beside its module; an edited file reruns it.
DATA = {"kinds": "kinds.yaml", "speed_accuracy": "engines.yaml"}

# The stability atlas is a figure for each of its pages.
PAGES = ["stiffness", "step", "release"]
AS_TABLES = ["bits", "kinds", "success"]  # their numbers are on docs/validation.md
FIGURES_OF_STUDIES = [study for study in STUDIES if study not in ("stability", *AS_TABLES)]


rule studies:
    input:
        expand("results/studies/figures/{study}.{suffix}", study=FIGURES_OF_STUDIES, suffix=["pdf", "png"]),
        expand("results/studies/figures/stability_{page}.{suffix}", page=PAGES, suffix=["pdf", "png"]),
        expand("results/studies/{study}.csv", study=AS_TABLES),


rule study:
    input:
        again=again("study", start=start_studies),
    output:
        csv="results/studies/{study}.csv",
    log:
        "results/studies/logs/{study}.log",
    benchmark:
        "results/studies/benchmarks/{study}.tsv"
    wildcard_constraints:
        study="|".join(STUDIES),
    conda:
        "../envs/freerock.yaml"
    threads: workflow.cores  # alone on the machine: it takes times
    params:
        code=lambda w: code("study", f"freerock_bench.{w.study}"),
        data=lambda w: sha256(PACKAGE.parent / "freerock_bench" / DATA[w.study]) if w.study in DATA else "",
        size=config.get("studies", "full"),
    message:
        "study: {wildcards.study}"
    script:
        "../scripts/study.py"


rule figure_study:
    input:
        csv=rules.study.output.csv,
        again=again("figure_study", start=start_studies),
    output:
        pdf="results/studies/figures/{study}.pdf",
        png=report(
            "results/studies/figures/{study}.png",
            caption="../report/figure.rst",
            category="Studies",
            labels={"figure": "{study}"},
        ),
        data="results/studies/figures/{study}.csv",
    log:
        "results/studies/logs/figure_{study}.log",
    benchmark:
        "results/studies/benchmarks/figure_{study}.tsv"
    wildcard_constraints:
        study="|".join(FIGURES_OF_STUDIES),
    conda:
        "../envs/freerock.yaml"
    params:
        figure=lambda w: w.study,
        caption=lambda w: declared(f"freerock_bench.figures.{w.study}")["caption"],
        code=lambda w: code("figure_study", f"freerock_bench.figures.{w.study}"),
    message:
        "study: figure of {wildcards.study}"
    script:
        "../scripts/figure_study.py"


rule figure_atlas:
    input:
        csv="results/studies/stability.csv",
        again=again("figure_atlas", start=start_studies),
    output:
        pdf="results/studies/figures/stability_{page}.pdf",
        png=report(
            "results/studies/figures/stability_{page}.png",
            caption="../report/figure.rst",
            category="Studies",
            labels={"figure": "stability: {page}"},
        ),
        data="results/studies/figures/stability_{page}.csv",
    log:
        "results/studies/logs/figure_stability_{page}.log",
    benchmark:
        "results/studies/benchmarks/figure_stability_{page}.tsv"
    wildcard_constraints:
        page="|".join(PAGES),
    conda:
        "../envs/freerock.yaml"
    params:
        figure="stability",
        page=lambda w: [w.page],
        caption=lambda w: declared("freerock_bench.figures.stability")["caption"],
        code=lambda w: code("figure_study", "freerock_bench.figures.stability"),
    message:
        "study: figure of stability, {wildcards.page}"
    script:
        "../scripts/figure_study.py"
