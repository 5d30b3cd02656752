TIDY = ["runs", "parameters", "epsilon", "choice", "restitution", "restitution_comparison"]
TIDY += ["predictions", "foundations"]
PRINTED = {"table1": "1, block configurations", "table2": "2, parameters", "table3": "3, discrepancies"}
REPORTED = ["runs", "choice", "restitution_comparison", *PRINTED]


rule tables:
    input:
        records=products("records"),
        fits=products("fits"),
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
        mem_mb=memory(1000),
    params:
        code=code("tables"),
        blocks=of_campaign(settings.geometries),
        release_angles_deg=of_campaign(settings.release_angles),
        published=lambda w: campaign(w).published and settings.plain(campaign(w).published)["values"],
        debonding=lambda w: campaign(w).fits.debonding,
    message:
        "{wildcards.campaign}: tables"
    script:
        "../scripts/tables.py"


rule printed_tables:
    input:
        csv_tables("runs", "parameters", "epsilon", *PRINTED),
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


rule figure_foundation_effect:
    input:
        records=products("records"),
    output:
        pdf="results/{campaign}/figures/foundation_effect.pdf",
        png=report(
            "results/{campaign}/figures/foundation_effect.png",
            caption="../report/foundation_effect.rst",
            category="{campaign}",
            subcategory="Figures",
            labels={"figure": "Effect of the foundation"},
        ),
        data="results/{campaign}/figures/foundation_effect.csv",
    log:
        "results/{campaign}/logs/figure_foundation_effect.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_foundation_effect.tsv"
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("figure_foundation_effect"),
        scenes=scenes,
        labels=of_campaign(settings.labels),
    message:
        "{wildcards.campaign}: figure of the effect of the foundation"
    script:
        "../scripts/figure_foundation_effect.py"


rule figure_models:
    input:
        fits=products("fits"),
    output:
        pdf="results/{campaign}/figures/models_{block}.pdf",
        png=report(
            "results/{campaign}/figures/models_{block}.png",
            caption="../report/models.rst",
            category="{campaign}",
            subcategory="Figures",
            labels={"figure": "Measured and modelled rotation of {block}"},
        ),
        data="results/{campaign}/figures/models_{block}.csv",
    log:
        "results/{campaign}/logs/figure_models_{block}.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_models_{block}.tsv"
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("figure_models"),
        scenes=scenes,
        labels=of_campaign(settings.labels),
    message:
        "{wildcards.campaign}: figure of the models of {wildcards.block}"
    script:
        "../scripts/figure_models.py"


rule figure_restitution:
    input:
        runs="results/{campaign}/tables/runs.csv",
        restitution="results/{campaign}/tables/restitution.csv",
        epsilon="results/{campaign}/tables/epsilon.csv",
    output:
        pdf="results/{campaign}/figures/restitution.pdf",
        png=report(
            "results/{campaign}/figures/restitution.png",
            caption="../report/restitution.rst",
            category="{campaign}",
            subcategory="Figures",
            labels={"figure": "Restitution of each impact"},
        ),
        data="results/{campaign}/figures/restitution.csv",
    log:
        "results/{campaign}/logs/figure_restitution.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_restitution.tsv"
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("figure_restitution"),
        blocks=of_campaign(settings.geometries),
        labels=of_campaign(settings.labels),
    message:
        "{wildcards.campaign}: figure of the restitution of each impact"
    script:
        "../scripts/figure_restitution.py"


rule recovered:
    input:
        parameters="results/{campaign}/tables/parameters.csv",
        truth=lambda w: f"{campaign(w).raw}/{campaign(w).truth}",
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


rule misfit_map:
    input:
        fits=products("fits"),
    output:
        maps="results/{campaign}/misfit_map.nc",
    log:
        "results/{campaign}/logs/misfit_map.log",
    benchmark:
        "results/{campaign}/benchmarks/misfit_map.tsv"
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("misfit_map"),
        scenes=scenes,
        blocks=of_campaign(settings.geometries),
        debonding=lambda w: campaign(w).fits.debonding,
    message:
        "{wildcards.campaign}: misfit maps"
    script:
        "../scripts/misfit_map.py"


rule figure_misfit_map:
    input:
        maps=rules.misfit_map.output.maps,
    output:
        pdf="results/{campaign}/figures/misfit_map.pdf",
        png=report(
            "results/{campaign}/figures/misfit_map.png",
            caption="../report/misfit_map.rst",
            category="{campaign}",
            subcategory="Figures",
            labels={"figure": "Misfit maps"},
        ),
        data="results/{campaign}/figures/misfit_map.csv",
    log:
        "results/{campaign}/logs/figure_misfit_map.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_misfit_map.tsv"
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("figure_misfit_map"),
        labels=of_campaign(settings.labels),
    message:
        "{wildcards.campaign}: figure of the misfit maps"
    script:
        "../scripts/figure_misfit_map.py"


rule figure_predictions:
    input:
        predictions="results/{campaign}/tables/predictions.csv",
        epsilon="results/{campaign}/tables/epsilon.csv",
    output:
        pdf="results/{campaign}/figures/predictions.pdf",
        png=report(
            "results/{campaign}/figures/predictions.png",
            caption="../report/predictions.rst",
            category="{campaign}",
            subcategory="Figures",
            labels={"figure": "Predictions from other runs and blocks"},
        ),
        data="results/{campaign}/figures/predictions.csv",
    log:
        "results/{campaign}/logs/figure_predictions.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_predictions.tsv"
    conda:
        "../envs/freerock.yaml"
    params:
        code=code("figure_predictions"),
        origin=lambda w: campaign(w).origin,
        labels=of_campaign(settings.labels),
    message:
        "{wildcards.campaign}: figure of the predictions"
    script:
        "../scripts/figure_predictions.py"


rule report:
    input:
        records=products("records"),
        fits=products("fits"),
        tables=csv_tables(*REPORTED),
        figures=lambda w: expand(
            "results/{campaign}/figures/{figure}.png", campaign=w.campaign, figure=figures_of(w)
        ),
        pages=lambda w: expand(
            "results/{campaign}/figures/qc_{test}.png", campaign=w.campaign, test=tests_of(w)
        ),
    output:
        html=report(
            "results/{campaign}/report.html",
            caption="../report/report.rst",
            category="{campaign}",
            subcategory="Report",
            labels={"page": "Report of the campaign"},
        ),
        provenance="results/{campaign}/provenance.json",
    log:
        "results/{campaign}/logs/report.log",
    benchmark:
        "results/{campaign}/benchmarks/report.tsv"
    conda:
        "../envs/freerock.yaml"
    resources:
        mem_mb=memory(1000),
    params:
        code=code("report"),
        campaign=of_campaign(settings.plain),
        blocks=of_campaign(settings.geometries),
    message:
        "{wildcards.campaign}: report"
    script:
        "../scripts/report.py"


rule complete:
    input:
        report=rules.report.output.html,
        targets=for_targets,
        runs="results/{campaign}/tables/runs.csv",
        printed=rules.printed_tables.output,
        recovered=lambda w: rules.recovered.output.csv if campaign(w).truth else [],
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
