# The figures of a campaign drawn for other targets than the double column, each with its style file in
# src/freerock/figures. Asked for by `figures_for` of the campaign, or by name:
# snakemake results/<campaign>/figures/slide/misfit_map.pdf


use rule figure_foundation_effect as figure_foundation_effect_for with:
    output:
        pdf="results/{campaign}/figures/{target}/foundation_effect.pdf",
        png="results/{campaign}/figures/{target}/foundation_effect.png",
        data="results/{campaign}/figures/{target}/foundation_effect.csv",
    log:
        "results/{campaign}/logs/figure_foundation_effect_{target}.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_foundation_effect_{target}.tsv"
    message:
        "{wildcards.campaign}: foundation effect for the {wildcards.target}"


use rule figure_models as figure_models_for with:
    output:
        pdf="results/{campaign}/figures/{target}/models_{block}.pdf",
        png="results/{campaign}/figures/{target}/models_{block}.png",
        data="results/{campaign}/figures/{target}/models_{block}.csv",
    log:
        "results/{campaign}/logs/figure_models_{block}_{target}.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_models_{block}_{target}.tsv"
    message:
        "{wildcards.campaign}: models for the {wildcards.target}"


use rule figure_restitution as figure_restitution_for with:
    output:
        pdf="results/{campaign}/figures/{target}/restitution.pdf",
        png="results/{campaign}/figures/{target}/restitution.png",
        data="results/{campaign}/figures/{target}/restitution.csv",
    log:
        "results/{campaign}/logs/figure_restitution_{target}.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_restitution_{target}.tsv"
    message:
        "{wildcards.campaign}: restitution for the {wildcards.target}"


use rule figure_misfit_map as figure_misfit_map_for with:
    output:
        pdf="results/{campaign}/figures/{target}/misfit_map.pdf",
        png="results/{campaign}/figures/{target}/misfit_map.png",
        data="results/{campaign}/figures/{target}/misfit_map.csv",
    log:
        "results/{campaign}/logs/figure_misfit_map_{target}.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_misfit_map_{target}.tsv"
    message:
        "{wildcards.campaign}: misfit map for the {wildcards.target}"


use rule figure_predictions as figure_predictions_for with:
    output:
        pdf="results/{campaign}/figures/{target}/predictions.pdf",
        png="results/{campaign}/figures/{target}/predictions.png",
        data="results/{campaign}/figures/{target}/predictions.csv",
    log:
        "results/{campaign}/logs/figure_predictions_{target}.log",
    benchmark:
        "results/{campaign}/benchmarks/figure_predictions_{target}.tsv"
    message:
        "{wildcards.campaign}: predictions for the {wildcards.target}"
