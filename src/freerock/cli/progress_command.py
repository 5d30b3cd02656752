"""Progress, failures and remaining time of the analysis of a campaign.

example:
  freerock progress palermo_virtual

Run it beside snakemake, in another terminal.
"""

import math
import time
from argparse import Namespace
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from freerock.config.campaign import load_config
from freerock.products.netcdf import verdict_of
from freerock.runs.verdict import in_one_line

STEPS = {  # products of a record, and their share of the work on it
    "records": ("records/{}.nc", 0.25),
    "fits": ("fits/{}.nc", 0.45),
    "quality pages": ("figures/qc_{}.csv", 0.30),
}


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("campaign", metavar="CAMPAIGN", nargs="*", help="by default those of config.yaml")


def run(chosen: Namespace) -> None:
    """Print the state of each campaign."""
    started = newest_run()
    for name, campaign in load_config(campaigns=chosen.campaign or None).campaigns.items():
        tests = [record.test for record in campaign.records]
        print(progress_text(name, progress(f"results/{name}", tests, started, time.time())))


@dataclass(frozen=True)
class Progress:
    """State of a campaign.

    Parameters
    ----------
    done : dict of str to int
        Number of records that a step has finished, by step.
    total : int
        Number of records.
    failed : list of (str, str)
        Records that could not be processed so far, with their reasons.
    complete : bool
        Everything is there.
    earlier : bool
        Some of the products are older than the newest run of Snakemake.
    share : float
        Done, of the work on all records.
    remaining_s : float
        Time the records still need [s] at the pace of the newest run of Snakemake; NaN when there was none,
        or when it has not made any product yet.
    """

    done: dict[str, int]
    total: int
    failed: list[tuple[str, str]]
    complete: bool
    earlier: bool
    share: float
    remaining_s: float


def newest_run(folder: str | Path = ".") -> float:
    """When Snakemake was last started in a folder [s since 1970], by the names of its logs; 0 if never."""
    started = [0.0]
    for log in Path(folder, ".snakemake/log").glob("*.snakemake.log"):
        with suppress(ValueError):
            started.append(datetime.strptime(log.name[:17], "%Y-%m-%dT%H%M%S").timestamp())
    return max(started)


def progress(results: str | Path, tests: Sequence[str], started_s: float, now_s: float) -> Progress:
    """Look at the products of a campaign.

    Parameters
    ----------
    results : path
        Folder of the campaign's products.
    tests : sequence of str
        Names of its records.
    started_s : float
        When the run that is looked at began [s since 1970]: its pace counts; 0 when it is not known.
    now_s : float
        The time now [s since 1970].
    """
    results, done, share, new = Path(results), {}, 0.0, 0.0
    for step, (name, weight) in STEPS.items():
        made = [made_s for test in tests if (made_s := _made(results / name.format(test))) is not None]
        done[step] = len(made)
        share += weight * len(made) / len(tests)
        new += weight * sum(made_s >= started_s for made_s in made) / len(tests)
    records = {test: results / STEPS["records"][0].format(test) for test in tests}
    verdicts = {test: verdict_of(path) for test, path in records.items() if path.exists()}
    failed = [(test, in_one_line(why)) for test, (verdict, why) in verdicts.items() if verdict == "fail"]
    remaining_s = (1 - share) / new * (now_s - started_s) if new and started_s else math.nan
    complete = (results / "complete.txt").exists() and share > 1 - 1e-9
    return Progress(done, len(tests), failed, complete, new < share - 1e-9, share, remaining_s)


def _made(path: Path) -> float | None:
    """When a product was written [s since 1970]; None while there is none."""
    try:
        return path.stat().st_mtime
    except OSError:
        return None


def progress_text(name: str, state: Progress) -> str:
    """The state as printed."""
    if state.complete:
        when = "complete"
    elif state.share > 1 - 1e-9:
        when = "records done; tables, figures and report are being made, or a record has failed"
    else:
        when = f"{100 * state.share:.0f} % of the work on the records done"
        if math.isfinite(state.remaining_s):
            when += f", about {_duration(state.remaining_s)} to go at the pace of the newest run"
        if state.earlier:
            when += " (products of earlier runs are taken to be up to date)"
    lines = [f"{name}: {when}"]
    lines += [f"  {step:13s} {number:5d} of {state.total}" for step, number in state.done.items()]
    lines += [f"  failed: {test}: {reasons}" for test, reasons in state.failed]
    lines += [f"  look at the runs: freerock review {name}"] if state.done["records"] else []
    return "\n".join(lines)


def _duration(seconds: float) -> str:
    minutes = round(seconds / 60)
    if minutes < 2:
        return f"{seconds:.0f} s"
    return f"{minutes} min" if minutes < 120 else f"{minutes // 60} h {minutes % 60} min"
