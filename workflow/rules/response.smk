# Ground motions on the identified laws: each job takes some of the motions, so that a cluster spreads them.


rule response:
    input:
        choice="results/{campaign}/tables/choice.csv",
        populations="results/{campaign}/tables/populations.csv",
        motions=lambda w: ground_motions_of(w.campaign).get(w.part, []),
        again=again("response"),
    output:
        responses="results/{campaign}/response/motions_{part}.csv",
    log:
        "results/{campaign}/logs/response_{part}.log",
    benchmark:
        "results/{campaign}/benchmarks/response_{part}.tsv"
    wildcard_constraints:
        part=r"\d+",
    conda:
        "../envs/freerock.yaml"
    resources:
        **resources_of("response"),
    params:
        code=code("response"),
        blocks=of_campaign(settings.geometries),
        debonding=lambda w: campaign(w).fits.debonding,
        ensemble=of_campaign(settings.ensemble),
    message:
        "{wildcards.campaign}: responses to ground motions, part {wildcards.part}"
    script:
        "../scripts/response.py"


rule fragility:
    input:
        responses=lambda w: [
            f"results/{w.campaign}/response/motions_{part}.csv" for part in ground_motions_of(w.campaign)
        ],
        again=again("fragility"),
    output:
        curves="results/{campaign}/tables/fragility.csv",
    log:
        "results/{campaign}/logs/fragility.log",
    benchmark:
        "results/{campaign}/benchmarks/fragility.tsv"
    conda:
        "../envs/freerock.yaml"
    resources:
        **resources_of("fragility"),
    params:
        code=code("fragility"),
        records=of_campaign(settings.scenes_tested),
    message:
        "{wildcards.campaign}: probability of overturning"
    script:
        "../scripts/fragility.py"
