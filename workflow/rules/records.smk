# Per record; a job takes on as many as the campaign's records_per_job says, in the order of its CSV file.


for name, section in CAMPAIGNS.items():
    for number, records in enumerate(section.batches, 1):
        tests = [each.test for each in records]
        own, shared = settings.record_settings(section, records, CHECKSUMS[name])
        own_fit, shared_fit = settings.fit_settings(section, records)
        told = f"{name}: {tests[0]}" + (f" to {tests[-1]}" if tests[1:] else "")

        rule:
            name:
                f"record_{name}_{number}"
            input:
                raw=raw_files(section, records),
            output:
                records=[f"results/{name}/records/{test}.nc" for test in tests],
            log:
                f"results/{name}/logs/record_{number}.log",
            benchmark:
                f"results/{name}/benchmarks/record_{number}.tsv"
            group:
                "batch"
            conda:
                "../envs/freerock.yaml"
            resources:
                mem_mb=memory(400),
                runtime=minutes(5 + len(tests)),
            params:
                code=code("record"),
                records=own,
                shared=shared,
            message:
                f"{told}: volts to θ(t), runs and impacts"
            script:
                "../scripts/record.py"

        rule:
            name:
                f"fit_{name}_{number}"
            input:
                records=[f"results/{name}/records/{test}.nc" for test in tests],
            output:
                fits=[f"results/{name}/fits/{test}.nc" for test in tests],
            log:
                f"results/{name}/logs/fit_{number}.log",
            benchmark:
                f"results/{name}/benchmarks/fit_{number}.tsv"
            group:
                "batch"
            conda:
                "../envs/freerock.yaml"
            resources:
                mem_mb=memory(700),
                runtime=minutes(5 + len(tests)),
            params:
                code=code("fit"),
                records=own_fit,
                shared=shared_fit,
            message:
                f"{told}: identifying the models"
            script:
                "../scripts/fit.py"

        rule:
            name:
                f"qc_{name}_{number}"
            input:
                records=[f"results/{name}/records/{test}.nc" for test in tests],
                fits=[f"results/{name}/fits/{test}.nc" for test in tests],
            output:
                png=[
                    report(
                        f"results/{name}/figures/qc_{test}.png",
                        caption="../report/qc.rst",
                        category=name,
                        subcategory="Quality control",
                        labels={"figure": f"Runs of {test}"},
                    )
                    for test in tests
                ],
                pdf=[f"results/{name}/figures/qc_{test}.pdf" for test in tests],
                data=[f"results/{name}/figures/qc_{test}.csv" for test in tests],
            log:
                f"results/{name}/logs/qc_{number}.log",
            benchmark:
                f"results/{name}/benchmarks/qc_{number}.tsv"
            group:
                "batch"
            conda:
                "../envs/freerock.yaml"
            resources:
                mem_mb=memory(500),
                runtime=minutes(5 + len(tests)),
            params:
                code=code("qc"),
                tests=tests,
                labels=settings.labels(section),
            message:
                f"{told}: a page per run"
            script:
                "../scripts/qc.py"
