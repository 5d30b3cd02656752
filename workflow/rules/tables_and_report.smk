TIDY = ["runs", "reasons", "parameters", "epsilon", "choice", "restitution", "restitution_comparison"]
TIDY += [
    "parts",
    "pulls",
    "candidates",
    "predictions",
    "foundations",
    "populations",
    "budget",
]
PRINTED = {"table1": "1, block configurations", "table2": "2, parameters", "table3": "3, discrepancies"}
REPORTED = ["runs", "choice", "candidates", "populations", "foundations", "restitution_comparison", "budget"]
REPORTED += ["epsilon", "predictions", *PRINTED]


rule tables:
    input:
        records=products("records"),
        fits=products("fits"),
        again=again("tables"),
    output:
        tidy=expand(
            "results/{{campaign}}/tables/{table}.csv",
            table=TIDY,
        ),
        printed=[
            report(
                f"results/{{campaign}}/tables/{table}.csv",
                caption="../report/tables.rst",
                category="{campaign}",
                subcategory="Tables",
                labels={"table": title, "format": "csv"},
            )
            for table, title in PRINTED.items()
        ],
    log:
        "results/{campaign}/logs/tables.log",
    benchmark:
        "results/{campaign}/benchmarks/tables.tsv"
    conda:
        "../envs/freerock.yaml"
    resources:
        **resources_of("tables"),
    params:
        code=code("tables"),
        blocks=of_campaign(settings.geometries),
        release_angles_deg=of_campaign(settings.release_angles),
        published=lambda w: campaign(w).published and settings.section_values(campaign(w).published)["values"],
        debonding=lambda w: campaign(w).fits.debonding,
    message:
        "{wildcards.campaign}: tables"
    script:
        "../scripts/tables.py"


rule printed_tables:
    input:
        tables=csv_tables("runs", "parameters", "epsilon", "candidates", "populations", *PRINTED),
        again=again("printed_tables"),
    output:
        printed=[
            report(
                f"results/{{campaign}}/tables/{table}.{suffix}",
                caption="../report/tables.rst",
                category="{campaign}",
                subcategory="Tables",
                labels={"table": title, "format": suffix},
            )
            for table, title in PRINTED.items()
            for suffix in ("md", "tex")
        ],
        candidates=[
            report(
                f"results/{{campaign}}/tables/candidates.{suffix}",
                caption="../report/candidates.rst",
                category="{campaign}",
                subcategory="Tables",
                labels={"table": "Candidates", "format": suffix},
            )
            for suffix in ("md", "tex")
        ],
        numbers="results/{campaign}/tables/numbers.tex",
    log:
        "results/{campaign}/logs/printed_tables.log",
    benchmark:
        "results/{campaign}/benchmarks/printed_tables.tsv"
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("printed_tables"),
        origin=lambda w: campaign(w).origin,
        doi=lambda w: campaign(w).published.doi if campaign(w).published else "",
        labels=of_campaign(settings.labels),
    message:
        "{wildcards.campaign}: tables as Markdown and LaTeX"
    script:
        "../scripts/printed_tables.py"


rule recovered:
    input:
        parameters="results/{campaign}/tables/parameters.csv",
        truth=lambda w: f"{campaign(w).raw}/{campaign(w).truth}",
        again=again("recovered"),
    output:
        csv="results/{campaign}/tables/recovered.csv",
        md=report(
            "results/{campaign}/tables/recovered.md",
            caption="../report/recovered.rst",
            category="{campaign}",
            subcategory="Tables",
            labels={"table": "Recovered against truth"},
        ),
        tex="results/{campaign}/tables/recovered.tex",
    log:
        "results/{campaign}/logs/recovered.log",
    benchmark:
        "results/{campaign}/benchmarks/recovered.tsv"
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("recovered"),
    message:
        "{wildcards.campaign}: identified against true values"
    script:
        "../scripts/recovered.py"


rule report:
    input:
        records=products("records"),
        fits=products("fits"),
        tables=csv_tables(*REPORTED),
        figures=lambda w: reported(w, "png"),
        captions=lambda w: reported(w, "txt"),
        pages=lambda w: expand(
            "results/{campaign}/figures/qc_{test}.png", campaign=w.campaign, test=tests_of(w)
        ),
        changes=changes_of,
        again=again("report"),
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
        methods="results/{campaign}/tables/methods.md",
        references="results/{campaign}/tables/methods.bib",
    log:
        "results/{campaign}/logs/report.log",
    benchmark:
        "results/{campaign}/benchmarks/report.tsv"
    conda:
        "../envs/freerock.yaml"
    resources:
        **resources_of("report"),
    params:
        code=code("report"),
        campaign=of_campaign(settings.section_values),
        blocks=of_campaign(settings.geometries),
    message:
        "{wildcards.campaign}: report"
    script:
        "../scripts/report.py"


rule complete:
    input:
        report=rules.report.output.html,
        runs="results/{campaign}/tables/runs.csv",
        printed=rules.printed_tables.output,
        recovered=lambda w: rules.recovered.output.csv if campaign(w).truth else [],
        again=again("complete"),
    output:
        complete="results/{campaign}/complete.txt",
    log:
        "results/{campaign}/logs/complete.log",
    benchmark:
        "results/{campaign}/benchmarks/complete.tsv"
    localrule: True
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("complete"),
    message:
        "{wildcards.campaign}: every record processed?"
    script:
        "../scripts/complete.py"
