"""Snakemake with this workflow, for those who don't know Snakemake: a progress bar, one line per failure.

example:
  freerock run palermo_virtual --cores 4

Runs snakemake --config campaigns=NAME with the Snakefile of the folder, or else with freerock's.
Whole products are not made again.
"""

import subprocess
import sys
import tempfile
import time
from argparse import ArgumentTypeError, Namespace
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TextIO

from freerock.cli.progress_command import progress
from freerock.config.campaign import load_config
from freerock.errors import FreerockError, printable
from freerock.jobs.home import HOME, SNAKEFILE

BAR = 40  # characters
PROFILE = "Using workflow specific profile "  # what Snakemake begins with, --quiet or not
EVERY_S = 0.5  # between looks at the products


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("campaign", metavar="NAME", nargs="*", help="by default those of config.yaml")
    add("--cores", metavar="N", type=_cores, help="number of parallel jobs; by default all cores")
    add("--slurm", action="store_true", help="run the jobs on the Slurm cluster of this machine")


def run(chosen: Namespace) -> None:
    """Analyse the campaigns; print the bar, then what failed or where the reports are."""
    campaigns = load_config(campaigns=chosen.campaign or None).campaigns
    tests = {name: [each.test for each in campaign.records] for name, campaign in campaigns.items()}
    code, told = analyse(command([*campaigns], chosen.cores, chosen.slurm), tests, sys.stderr)
    for line in told:
        print(printable(line), file=sys.stderr)
    if code:
        remedy = "correct what the lines above say, and run the same command again"
        raise FreerockError("freerock run", f"snakemake ended with exit code {code}", remedy)
    for name in campaigns:
        print(f"results/{name}/report.html: the report; open it in a browser")


def command(names: Sequence[str], cores: int | None, slurm: bool) -> list[str]:
    """The command line of Snakemake; the folder's own Snakefile and profile come before freerock's."""
    words = [sys.executable, "-m", "snakemake", "--quiet", "all"]
    words += ["--config", f"campaigns=[{','.join(names)}]"]
    if not Path("Snakefile").exists():
        words += ["--snakefile", str(SNAKEFILE)]
    if not Path("profiles/default").exists():
        words += ["--workflow-profile", str(HOME / "profiles/default")]
    if slurm:
        words += ["--profile", str(HOME / "profiles/slurm")]
    return words + (["--cores", str(cores)] if cores else [])


def analyse(words: Sequence[str], tests: Mapping[str, Sequence[str]], out: TextIO) -> tuple[int, list[str]]:
    """Run Snakemake and show the progress meanwhile.

    Returns
    -------
    code : int
        Snakemake's exit code.
    told : list of str
        The lines that it, its jobs and the workflow said of failures and of the end, each once.
    """
    started_s, shown = time.time(), ""
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as said:
        with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=said) as snakemake:
            with suppress(KeyboardInterrupt):
                while snakemake.poll() is None:
                    shown = _show(bar(share(tests, started_s)), shown, out)
                    time.sleep(EVERY_S)
            code = snakemake.wait()  # after Ctrl+C it ends its jobs first
        if not code:
            _show(bar(1.0), shown, out)
        print(file=out)
        said.seek(0)
        lines = [line.rstrip() for line in said]
    reports = {f"results/{name}/report.html" for name in tests}
    return code, [
        line
        for line in dict.fromkeys(lines)
        if line and not line.startswith(PROFILE) and line.partition(":")[0] not in reports
    ]


def share(tests: Mapping[str, Sequence[str]], started_s: float) -> float:
    """Share of the work on the records of all campaigns that is done."""
    done = total = 0.0
    for name, names in tests.items():
        with suppress(FreerockError):  # a product that is just being replaced
            done += len(names) * progress(f"results/{name}", names, started_s, time.time()).share
        total += len(names)
    return done / total if total else 0.0


def bar(done: float) -> str:
    """The bar as a line; before the end it does not say 100 %, since tables, figures and report come last."""
    full = int(BAR * done)
    return f"[{'#' * full}{'.' * (BAR - full)}] {min(int(100 * done), 99) if done < 1 else 100:3d} %"


def _show(line: str, shown: str, out: TextIO) -> str:
    """Redraw the line on a terminal; elsewhere print it where it changed by a tenth."""
    if out.isatty():
        print(f"\r{line}", end="", file=out, flush=True)
    elif line.count("#") // 4 != shown.count("#") // 4 or not shown:
        print(line, file=out, flush=True)
    return line


def _cores(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise ArgumentTypeError(f"{text!r} is no number of cores, as 4")
    return int(text)
