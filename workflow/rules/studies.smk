"""Studies of the methods, of no campaign: `snakemake studies`, in minutes with `--config studies=small`."""

BENCH = PACKAGE.parent / "freerock_bench"
STUDIES = ["speed_accuracy", "stability"]
DATA = {"speed_accuracy": "engines.yaml"}
PAGES = ["stability_stiffness", "stability_step", "stability_release"]  # of the stability atlas
STUDY_OF = {"speed_accuracy": "speed_accuracy"} | dict.fromkeys(PAGES, "stability")


rule studies:
    input:
        expand("results/studies/{study}.csv", study=STUDIES),
        expand("results/studies/figures/{name}.{suffix}", name=STUDY_OF, suffix=["pdf", "png"]),


rule study:
    input:
        data=lambda w: [str(BENCH / DATA[w.study])] if w.study in DATA else [],
    output:
        csv="results/studies/{study}.csv",
    log:
        "results/studies/logs/study_{study}.log",
    benchmark:
        "results/studies/benchmarks/study_{study}.tsv"
    wildcard_constraints:
        study="|".join(STUDIES),
    conda:
        "../envs/freerock.yaml"
    threads: workflow.cores  # alone on the machine: it takes times
    params:
        code=lambda w: code("study", f"freerock_bench.{w.study}"),
        size=config.get("studies", "full"),
    message:
        "study: {wildcards.study}"
    script:
        "../scripts/study.py"


rule study_figure:
    input:
        csv=lambda w: f"results/studies/{STUDY_OF[w.name]}.csv",
    output:
        pdf="results/studies/figures/{name}.pdf",
        png="results/studies/figures/{name}.png",
        data="results/studies/figures/{name}.csv",
    log:
        "results/studies/logs/study_figure_{name}.log",
    benchmark:
        "results/studies/benchmarks/study_figure_{name}.tsv"
    wildcard_constraints:
        name="|".join(STUDY_OF),
    conda:
        "../envs/freerock.yaml"
    params:
        code=lambda w: code("study_figure", f"freerock_bench.figures.{STUDY_OF[w.name]}"),
        page=lambda w: w.name.split("_")[1:] if w.name in PAGES else [],
    message:
        "study: figure {wildcards.name}"
    script:
        "../scripts/study_figure.py"
