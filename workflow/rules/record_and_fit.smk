# Per record; a job takes on several, as freerock.jobs.batches divides them. Their files can't be outputs of one
# rule, whose lists of outputs are all equally long, so each job has a rule of its own. The rules record, fit and
# quality stand for all of a step: as targets, and as names for --set-resources.

from freerock.jobs.batches import batches

BATCHES = {
    name: batches([each.test for each in section.records], section.records_per_job)
    for name, section in CAMPAIGNS.items()
}

for name, section in CAMPAIGNS.items():
    of_test = {each.test: each for each in section.records}
    for tests in BATCHES[name]:
        records = [of_test[test] for test in tests]
        own, shared = settings.record_settings(section, records, CHECKSUMS[name])
        own_fit, shared_fit = settings.fit_settings(section, records)
        job = f"{name}-{tests[0]}"  # no name has a hyphen: no two are joined to the same
        who = f"{name}: {tests[0]}" + (f" and {len(tests) - 1} more" if tests[1:] else "")

        rule:
            name:
                f"record_{job}"
            input:
                raw=raw_files_of(name, records),
                again=again(f"record_{job}", name),
            output:
                records=[f"results/{name}/records/{test}.nc" for test in tests],
            log:
                f"results/{name}/logs/record_{tests[0]}.log",
            benchmark:
                f"results/{name}/benchmarks/record_{tests[0]}.tsv"
            group:
                "batch"
            conda:
                "../envs/freerock.yaml"
            resources:
                **of_batch("record", len(tests)),
            params:
                code=code("record"),
                records=own,
                shared=shared,
            message:
                f"{who}: volts to θ(t), runs and impacts"
            script:
                "../scripts/record.py"

        rule:
            name:
                f"fit_{job}"
            input:
                records=getattr(rules, f"record_{job}").output.records,
                again=again(f"fit_{job}", name),
            output:
                fits=[f"results/{name}/fits/{test}.nc" for test in tests],
            log:
                f"results/{name}/logs/fit_{tests[0]}.log",
            benchmark:
                f"results/{name}/benchmarks/fit_{tests[0]}.tsv"
            group:
                "batch"
            conda:
                "../envs/freerock.yaml"
            resources:
                **of_batch("fit", len(tests)),
            params:
                code=code("fit"),
                records=own_fit,
                shared=shared_fit,
            message:
                f"{who}: identifying the models"
            script:
                "../scripts/fit.py"

        rule:
            name:
                f"quality_{job}"
            input:
                records=getattr(rules, f"record_{job}").output.records,
                fits=getattr(rules, f"fit_{job}").output.fits,
                again=again(f"quality_{job}", name),
            output:
                png=[
                    report(
                        f"results/{name}/figures/qc_{test}.png",
                        caption="../report/quality.rst",
                        category=name,
                        subcategory="Quality control",
                        labels={"figure": f"Runs of {test}"},
                    )
                    for test in tests
                ],
                pdf=[f"results/{name}/figures/qc_{test}.pdf" for test in tests],
                data=[f"results/{name}/figures/qc_{test}.csv" for test in tests],
            log:
                f"results/{name}/logs/quality_{tests[0]}.log",
            benchmark:
                f"results/{name}/benchmarks/quality_{tests[0]}.tsv"
            group:
                "batch"
            conda:
                "../envs/freerock.yaml"
            resources:
                **of_batch("quality", len(tests)),
            params:
                code=code("quality"),
                tests=tests,
                labels=settings.labels(section),
            message:
                f"{who}: a page per run"
            script:
                "../scripts/quality.py"


rule record:
    input:
        of_all("records/{test}.nc"),


rule fit:
    input:
        of_all("fits/{test}.nc"),


rule quality:
    input:
        of_all("figures/qc_{test}.png"),
