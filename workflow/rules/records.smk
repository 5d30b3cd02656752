"""Per record: from volts to impacts, the laws identified on its runs, a page per run.

Pages have less priority: only the report waits for them, and they fill the cores beside tables and figures.
"""


rule record:
    input:
        raw=raw_files,
    output:
        record="results/{campaign}/records/{test}.nc",
    log:
        "results/{campaign}/logs/record_{test}.log",
    priority: 1
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("record"),
        settings=record_settings,
    message:
        "{wildcards.campaign}: {wildcards.test}: volts to rotation, runs and impacts"
    script:
        "../scripts/record.py"


rule fit:
    input:
        record=rules.record.output.record,
    output:
        fits="results/{campaign}/fits/{test}.nc",
    log:
        "results/{campaign}/logs/fit_{test}.log",
    priority: 1
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("fit"),
        settings=fit_settings,
    message:
        "{wildcards.campaign}: {wildcards.test}: identifying the models"
    script:
        "../scripts/fit.py"


rule quality:
    input:
        record=rules.record.output.record,
        fits=rules.fit.output.fits,
    output:
        png=report(
            "results/{campaign}/figures/qc_{test}.png",
            caption="../report/quality.rst",
            category="{campaign}",
            subcategory="Quality control",
            labels={"figure": "Runs of {test}"},
        ),
        pdf="results/{campaign}/figures/qc_{test}.pdf",
        data="results/{campaign}/figures/qc_{test}.csv",
    log:
        "results/{campaign}/logs/quality_{test}.log",
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("quality"),
        labels=of_campaign(settings.labels),
    message:
        "{wildcards.campaign}: {wildcards.test}: a page per run"
    script:
        "../scripts/quality.py"
