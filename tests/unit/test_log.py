"""Why jobs failed, from their logs."""

import logging

from freerock.jobs.log import in_utf8, why_failed


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


def test_snakemakes_log_is_in_utf8_whatever_the_locale(tmp_path):
    path = tmp_path / "run.snakemake.log"
    handler = logging.FileHandler(path, encoding="iso-8859-1")
    logger = logging.getLogger("snakemake.logging")
    logger.addHandler(handler)
    try:
        in_utf8()
        handler.emit(
            logging.LogRecord(
                "snakemake", logging.ERROR, "", 0, f"log: {tmp_path}/θ.log (check log file", (), None
            )
        )
    finally:
        logger.removeHandler(handler)
        handler.close()
    (tmp_path / "θ.log").write_bytes(b"first\nlast \x1b[2J M\xe4rz\n")
    assert why_failed([path]) == ["last \\x1b[2J M\N{REPLACEMENT CHARACTER}rz"]
