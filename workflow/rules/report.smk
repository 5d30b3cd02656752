"""The report of a campaign with the checksums of all products, and the end of the campaign."""

REPORTED = ["runs", "choice", "populations", "restitution", "summary", *PRINTED]


rule report:
    input:
        records=of_tests("records/{test}.nc"),
        fits=of_tests("fits/{test}.nc"),
        tables=csv_tables(*REPORTED),
        other_tables=csv_tables(*sorted({*TIDY} - {*REPORTED})),
        printed=rules.printed_tables.output,
        figures=of_figures("png"),
        captions=of_figures("txt"),
        other_figures=of_figures("pdf") + of_figures("csv"),
        pages=of_tests("figures/qc_{test}.png"),
        pages_in_print=of_tests("figures/qc_{test}.pdf"),
        pages_as_numbers=of_tests("figures/qc_{test}.csv"),
        changes=desk_log,
    output:
        html=report(
            "results/{campaign}/report.html",
            caption="../report/report.rst",
            category="{campaign}",
            subcategory="Report",
            labels={"page": "Report of the campaign"},
        ),
        provenance="results/{campaign}/provenance.json",
        captions="results/{campaign}/figures/captions.tex",
        paper="results/{campaign}/tables/spanos2017.tex",
        methods="results/{campaign}/tables/methods.md",
        references="results/{campaign}/tables/methods.bib",
    log:
        "results/{campaign}/logs/report.log",
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("report"),
        campaign=of_campaign(settings.section_values),
    message:
        "{wildcards.campaign}: report"
    script:
        "../scripts/report.py"


rule complete:
    input:
        report=rules.report.output.html,
        runs="results/{campaign}/tables/runs.csv",
    output:
        complete="results/{campaign}/complete.txt",
    log:
        "results/{campaign}/logs/complete.log",
    localrule: True
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("complete"),
    message:
        "{wildcards.campaign}: every record processed?"
    script:
        "../scripts/complete.py"
