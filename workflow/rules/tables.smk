"""Tables of a campaign: as numbers, and as they are printed."""

TIDY = [
    "runs",
    "reasons",
    "parameters",
    "epsilon",
    "choice",
    "restitution",
]
TIDY += ["pulls", "paper", "predictions", "foundations", "populations", "budget", "summary"]
PRINTED = {"table1": "1, block configurations", "table2": "2, parameters", "table3": "3, ε_θ"}


rule tables:
    input:
        records=of_tests("records/{test}.nc"),
        fits=of_tests("fits/{test}.nc"),
    output:
        tidy=csv_tables(*TIDY),
        printed=[printed_table(name, "csv", title) for name, title in PRINTED.items()],
    log:
        "results/{campaign}/logs/tables.log",
    priority: 1
    conda:
        "../envs/freerock.yaml"
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
        tables=csv_tables("runs", "epsilon", "choice", "populations", "restitution", *PRINTED),
    output:
        printed=[
            printed_table(name, suffix, title)
            for name, title in {**PRINTED, "restitution": "Restitution of each impact"}.items()
            for suffix in ("md", "tex")
        ],
        numbers="results/{campaign}/tables/numbers.tex",
    log:
        "results/{campaign}/logs/printed_tables.log",
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
