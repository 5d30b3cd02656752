"""Why jobs failed, from their logs."""

from freerock.jobs.log import why_failed


def test_why_jobs_failed_is_what_their_logs_end_with(tmp_path):
    told = {
        "record_1": "one (1 of 2)\na.nc: cannot be written; free some space\n",
        "complete": "a: b\nc: d\n",
    }
    for name, text in told.items():
        (tmp_path / f"{name}.log").write_text(text)
    lines = [
        f"    log: {tmp_path}/{name}.log (check log file(s) for error details)" for name in (*told, "none")
    ]
    (tmp_path / "snakemake.log").write_text("\n".join([*lines, *lines]))
    assert why_failed([tmp_path / "snakemake.log"]) == [
        "a.nc: cannot be written; free some space",
        "a: b",
        "c: d",
    ]
