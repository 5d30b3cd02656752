rule record:
    input:
        raw=lambda w: filter(os.path.exists, raw_files(w)),  # missing: told by the script
        code=code("record"),
    output:
        record="results/{campaign}/records/{test}.nc",
    log:
        "results/{campaign}/logs/record_{test}.log",
    benchmark:
        "results/{campaign}/benchmarks/record_{test}.tsv"
    conda:
        "../envs/freerock.yaml"
    params:
        raw=lambda w: campaign(w).raw,
        file=lambda w: record(w).file,
        sha256=checksum,
        channels=lambda w: record(w).channels,
        attributes=lambda w: campaign(w).attributes(w.test),
        block=lambda w: geometry(campaign(w).blocks[record(w).block]),
        lasers=lambda w: [plain(campaign(w).lasers[name]) for name in record(w).lasers],
        rotation=lambda w: plain(campaign(w).processing.rotation),
        runs=lambda w: plain(campaign(w).processing.runs),
        impacts=lambda w: plain(campaign(w).processing.impacts),
        overrides=lambda w: record(w).overrides,
        exclusions=lambda w: record(w).exclusions,
        excluded=lambda w: record(w).reason if record(w).excluded else "",
    message:
        "{wildcards.campaign}/{wildcards.test}: volts to θ(t), runs and impacts"
    script:
        "../scripts/record.py"


rule fit:
    input:
        record=rules.record.output.record,
        code=code("fit"),
    output:
        fits="results/{campaign}/fits/{test}.nc",
    log:
        "results/{campaign}/logs/fit_{test}.log",
    benchmark:
        "results/{campaign}/benchmarks/fit_{test}.tsv"
    conda:
        "../envs/freerock.yaml"
    params:
        block=lambda w: geometry(campaign(w).blocks[record(w).block]),
        attributes=lambda w: campaign(w).attributes(w.test),
        models=lambda w: campaign(w).fits.models,
        free=lambda w: {m: list(free) for m, free in campaign(w).fits.freed.items()},
        pooled=lambda w: campaign(w).fits.pooled,
        options=lambda w: plain(campaign(w).fits, "models", "free", "paper_mode", "pooled"),
        impacts=lambda w: plain(campaign(w).processing.impacts),
    message:
        "{wildcards.campaign}/{wildcards.test}: identifying the models"
    script:
        "../scripts/fit.py"


rule qc:
    input:
        record=rules.record.output.record,
        fits=rules.fit.output.fits,
        code=code("qc"),
    output:
        pdf="results/{campaign}/figures/qc_{test}.pdf",
        png=report(
            "results/{campaign}/figures/qc_{test}.png",
            caption="../report/qc.rst",
            category="{campaign}",
            subcategory="Quality control",
            labels={"figure": "Runs of {test}"},
        ),
        data="results/{campaign}/figures/qc_{test}.csv",
    log:
        "results/{campaign}/logs/qc_{test}.log",
    benchmark:
        "results/{campaign}/benchmarks/qc_{test}.tsv"
    conda:
        "../envs/freerock.yaml"
    params:
        labels=labels,
    message:
        "{wildcards.campaign}/{wildcards.test}: a page per run"
    script:
        "../scripts/qc.py"
