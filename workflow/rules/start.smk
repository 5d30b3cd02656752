# Before anything runs: what a run that was killed left behind, folders to write to, and times from the future.

from freerock.jobs.guard import check_clock, check_room, job_runs, run_starts

if workflow.is_main_process:
    run_starts()
    try:
        for name in asked_for():
            check_room(Path("results", name))
        check_clock(
            [path for name in CAMPAIGNS for path in Path("results", name).rglob("*")],
            [Path(file) for each in CAMPAIGNS.values() for file in raw_files(each, each.records)],
        )
    except FreerockError as error:
        sys.exit(str(error))
elif not workflow.is_main_process:
    job_runs()
