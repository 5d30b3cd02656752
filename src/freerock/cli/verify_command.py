"""Check, file by file, whether the products of a campaign are those that a run would make now.

example:
  freerock verify palermo_virtual

Reads every record and product, compares checksums with results/NAME/ledger, and lists products that are
  missing
  damaged   changed since it was written
  stale     made from other records, settings or code than the present ones
  foreign   not a product
Records that failed are listed with what to do.
Products of other software versions are listed, but count as whole.
Exit code 0: all products are whole. Nothing is made or changed.
"""

import subprocess
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from pathlib import Path

from freerock.config.campaign import load_config
from freerock.errors import FreerockError
from freerock.jobs.home import SNAKEFILE
from freerock.jobs.whole_or_rerun import VERIFIED


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("campaign", metavar="CAMPAIGN", nargs="*", help="by default those of config.yaml")


def run(chosen: Namespace) -> None:
    """Print what is not as a run would make it; raise when there is anything."""
    names = [*load_config(campaigns=chosen.campaign or None).campaigns]
    told, whole = verification(names)
    print(told, end="")
    if not whole:
        raise refusal(f"results/{names[0]}" if len(names) == 1 else "results", chosen.campaign, told)


def refusal(where: str, campaigns: Sequence[str], told: str) -> FreerockError:
    """The error of products that are not whole, with the remedy for what a verification tells."""
    listed = ",".join(campaigns)
    listed = f"[{listed}]" if len(campaigns) > 1 else listed
    states = {line.partition(":")[0] for line in told.splitlines()}
    steps = ["correct or exclude each record that failed"] * ("failed" in states)
    steps += [f"run snakemake --config campaigns={listed}" if listed else "run snakemake"]
    steps += ["delete what is foreign"] * ("foreign" in states)
    return FreerockError(where, "some products are not as a run would make them", ", and ".join(steps))


def verification(names: Sequence[str]) -> tuple[str, bool]:
    """What a verification of campaigns tells, in lines, and whether all is whole.

    A workflow that is refused ends the program with its own lines.
    """
    snakefile = "Snakefile" if Path("Snakefile").exists() else SNAKEFILE
    plan = [sys.executable, "-m", "snakemake", "--snakefile", snakefile, "--dry-run", "--quiet", "all"]
    plan += ["--config", f"campaigns=[{','.join(names)}]", "verify=true"]
    done = subprocess.run(plan, capture_output=True, text=True)
    _, verified, told = done.stdout.partition(f"{VERIFIED} ")
    if done.returncode or not verified:  # the workflow itself is refused
        sys.exit(done.stderr.strip())
    whole, _, lines = told.partition("\n")
    return lines, whole == str(True)
