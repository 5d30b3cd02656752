"""Whether products are what a run would make now: their plan is compared with the ledger, by content.

A product is written whole by `files.atomic` and entered last (`ledger.at_work`); `guard` clears what a killed
run leaves. `workflow/rules/plan_and_ledger.smk` compares each job, and gives one in doubt a newer input
(`newer_input`).
"""

import os
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, get_args

from freerock.jobs.contents import Checksums, Known, look, noted
from freerock.jobs.finish_campaign import failed_records
from freerock.jobs.ledger import LEDGER_FOLDER, Entry, as_json, entry_path, read_entry, software

VERIFIED = "verified:"  # comes before what a verification found, below what Snakemake tells
QUICK_LOOK = "quick_look.png"  # what `freerock new-campaign` shows of the records
NOT_PRODUCTS = {LEDGER_FOLDER, "logs", "benchmarks", "plan", QUICK_LOOK}  # in a campaign's folder of results
SHOWN = 5  # of a list
State = Literal["missing", "damaged", "stale"]


@dataclass(frozen=True)
class PlannedJob:
    """A job of the plan, as it would be done now.

    Parameters
    ----------
    log : str
        Path of its log, by which the ledger knows it.
    inputs, outputs : sequence of str
        Paths of its files.
    settings : mapping
        Parameters of its rule.
    """

    log: str
    inputs: Sequence[str]
    outputs: Sequence[str]
    settings: Mapping[str, Any]


@dataclass(frozen=True)
class Doubt:
    """A product that is not what a run would make.

    Parameters
    ----------
    path : str
    state : str
        missing; damaged, no longer as it was written; stale, made from or by something else.
    why : str
        The predicate of a sentence about the product.
    derived : bool
        Nothing else is the matter than that it was made from a product in doubt.
    """

    path: str
    state: State
    why: str
    derived: bool = False


def known_looks(entries: Iterable[Entry | None]) -> Known:
    """Checksum by path and look, as jobs and earlier runs saw files; nothing of what contradicts itself."""
    seen = noted()
    for entry in filter(None, entries):
        sums = entry.inputs | entry.outputs
        seen += [(path, sums[path], tuple(own)) for path, own in entry.looks.items() if path in sums]
    found: Known = {}
    for path, told, each in seen:
        looks = found.setdefault(path, {})
        if looks.setdefault(each, told) != told:
            looks[each] = ""
    return found


class PlanAgainstLedger:
    """A plan compared with the ledger, job by job.

    Parameters
    ----------
    folders : iterable of Path
        `results/NAME` of the plan's campaigns: what their ledgers saw of files counts.
    thorough : bool
        Every file is read, even one that looks as it did.

    Attributes
    ----------
    entries : dict of str to Entry or None
        What the ledger holds of each step, by its log.
    again : set of str
        Logs of the steps in doubt, by the files as they are; doubts about what they read do not count.
    """

    def __init__(self, folders: Iterable[Path], thorough: bool = False) -> None:
        found = (path for folder in folders for path in (folder / LEDGER_FOLDER).glob("*.json"))
        self._ledger = {path: read_entry(path) for path in found}
        self.contents = Checksums({} if thorough else known_looks(self._ledger.values()))
        self.steps: list[PlannedJob] = []
        self.entries: dict[str, Entry | None] = {}
        self.again: set[str] = set()

    def add(self, step: PlannedJob) -> bool:
        """Whether a step is in doubt, by the files as they are; one whose products were never made is.

        Raises
        ------
        FreerockError
            A file can't be read, or a FIFO, a socket or a device is in its place.
        """
        self.contents.look_at([*step.inputs, *step.outputs])
        look(step.log)
        look(entry_path(step.log))
        self.steps.append(step)
        entry = self.entries[step.log] = self._ledger.get(entry_path(step.log))
        if any(_doubts(step, entry, self.contents, ())):
            self.again.add(step.log)
        return step.log in self.again

    @cached_property
    def doubts(self) -> dict[str, list[Doubt]]:
        """Doubts by the log of the step; what only stems from another step's is marked as derived."""
        maker = {path: step for step in self.steps for path in step.outputs}
        found: dict[str, list[Doubt]] = {}

        def of(step: PlannedJob) -> list[Doubt]:
            if step.log not in found:
                made = [path for path in step.inputs if path in maker]
                doubtful = [path for path in made if path in {doubt.path for doubt in of(maker[path])}]
                told = _doubts(step, self.entries[step.log], self.contents, doubtful)
                found[step.log] = [*told] if doubtful or step.log in self.again else []
            return found[step.log]

        return {step.log: doubts for step in self.steps if (doubts := of(step))}


def compare(steps: Iterable[PlannedJob], thorough: bool = False) -> PlanAgainstLedger:
    """Compare a plan with the ledger and with the files that are there now.

    Parameters
    ----------
    steps : iterable of PlannedJob
        Those of the plan, in any order.
    thorough : bool
        As of `PlanAgainstLedger`.

    Raises
    ------
    FreerockError
        A file can't be read.
    """
    steps = [*steps]
    found = PlanAgainstLedger({Path(step.log).parents[1] for step in steps}, thorough)
    found.contents.look_at(path for step in steps for path in (*step.inputs, *step.outputs))
    for step in steps:
        found.add(step)
    return found


def _doubts(
    step: PlannedJob, entry: Entry | None, contents: Checksums, doubtful: Sequence[str]
) -> Iterator[Doubt]:
    """Doubts about the products of a step; `doubtful` are the products in doubt among its inputs."""
    there = [path for path in step.outputs if contents.sha256(path)]
    yield from (Doubt(path, "missing", "is missing") for path in step.outputs if path not in there)
    if entry is None:
        yield from (Doubt(path, "stale", "has no entry in the ledger") for path in there)
        return
    why = "; ".join(_otherwise(step, entry, contents, doubtful))
    for path in there:
        if contents.sha256(path) != entry.outputs.get(path):
            yield Doubt(path, "damaged", "is not as it was written")
        elif why:
            yield Doubt(path, "stale", f"was made {why}")
        elif doubtful:
            yield Doubt(path, "stale", f"was made from {some(doubtful)}", derived=True)


def _otherwise(
    step: PlannedJob, entry: Entry, contents: Checksums, doubtful: Collection[str]
) -> Iterator[str]:
    """From and by what else than now the products of a step were made."""
    if [*entry.inputs] != [*dict.fromkeys(step.inputs)]:  # two records may be of one file
        yield f"from other files ({some(sorted({*entry.inputs} ^ {*step.inputs}) or step.inputs)})"
    kept = [path for path in step.inputs if path in entry.inputs and path not in doubtful]
    if changed := [path for path in kept if entry.inputs[path] != contents.sha256(path)]:
        yield f"from another {some(changed)}"
    then, now = {**entry.settings}, as_json(step.settings)
    code_then, code_now = then.pop("code", ""), now.pop("code", "")
    if changed := [*differences(then, now)]:
        yield f"by other settings ({some(changed)})"
    if code_then != code_now:
        yield "by other code"


def differences(then: Any, now: Any, name: str = "") -> Iterator[str]:
    """The values in which nested settings differ, each with its name, as `block.mass_kg 2.98, now 2.97`."""
    if isinstance(then, dict) and isinstance(now, dict):
        for key in dict.fromkeys([*then, *now]):
            yield from differences(then.get(key), now.get(key), f"{name}.{key}" if name else key)
    elif _are_sections(then) and _are_sections(now) and len(then) == len(now):
        for i, (before, after) in enumerate(zip(then, now, strict=True), 1):
            yield from differences(before, after, f"{name}.{i}")
    elif then != now:
        before, after = (f"{each:.12g}" if isinstance(each, float) else each for each in (then, now))
        known = ("nothing" if each in ("", None) else each for each in (before, after))
        yield " ".join("{} {}, now {}".format(name, *known).split())[:120]


def _are_sections(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(each, dict) for each in value)


def some(words: Sequence[str]) -> str:
    """Some words of a list, and how many more there are."""
    more = f" and {len(words) - SHOWN} more" if len(words) > SHOWN else ""
    return ", ".join(words[:SHOWN]) + more


def in_doubt(found: PlanAgainstLedger) -> list[str]:
    """A line for each of some products in doubt, and one for the others; without those never made."""
    told = [
        doubt
        for log, doubts in found.doubts.items()
        if found.entries[log] or {doubt.state for doubt in doubts} != {"missing"}
        for doubt in doubts
        if not doubt.derived
    ]
    lines = [f"{doubt.path} {doubt.why}" for doubt in told[:SHOWN]]
    return lines + ([f"and {len(told) - SHOWN} more"] if len(told) > SHOWN else [])


def made_by_other_software(entries: Iterable[Entry | None]) -> str:
    """How many products were made by other software than what is installed, and which; else empty."""
    now, products, changed = software(), 0, set()
    for entry in filter(None, entries):
        then = entry.software
        other = {name for name in {*now, *then} if now.get(name) != then.get(name)}
        products += len(entry.outputs) if other else 0
        changed |= {f"{name} {then.get(name, 'none')}, now {now.get(name, 'none')}" for name in other}
    return f"{products} products were made by other software ({some(sorted(changed))})" if changed else ""


def verified(found: PlanAgainstLedger, folder: Path) -> tuple[list[str], bool]:
    """A line for each product of a campaign that is not what a run would make, failed record and other file.

    Parameters
    ----------
    found : PlanAgainstLedger
        Of a plan that holds the whole campaign.
    folder : Path
        `results/NAME`.

    Returns
    -------
    lines : list of str
        Each begins with missing, damaged, stale, failed or foreign; the last says how many products are so.
    whole : bool
        There is none.
    """
    products = {path for step in found.steps for path in step.outputs if folder in Path(path).parents}
    doubts = [each for doubts in found.doubts.values() for each in doubts if each.path in products]
    doubts.sort(key=lambda each: each.path)
    lines = [f"{each.state}: {each.path}" for each in doubts if each.state != "stale"]
    lines += [f"stale: {each.path} {each.why}" for each in doubts if each.state == "stale"]
    doubtful, runs = {each.path for each in doubts}, f"{folder}/tables/runs.csv"
    if f"{folder}/complete.txt" in doubtful and runs in products - doubtful:
        lines += [f"failed: record {test}: {why}" for test, why in failed_records(runs).items()]
    foreign = left_over(folder, products)
    lines += [f"foreign: {folder}/{path}" for path in foreign]
    if told := made_by_other_software(found.entries.values()):
        lines.append(f"software: {told}")
    numbers = {state: sum(doubt.state == state for doubt in doubts) for state in get_args(State)}
    numbers = {"whole": len(products) - len(doubts)} | numbers | {"foreign": len(foreign)}
    lines.append(f"{folder}: " + ", ".join(f"{number} {state}" for state, number in numbers.items()))
    return lines, not doubts and not foreign


def left_over(folder: Path, products: Collection[str]) -> list[str]:
    """Files in a campaign's folder of results that are none of its products, relative to it.

    Parameters
    ----------
    folder : Path
        `results/NAME`; hidden files and those in `NOT_PRODUCTS` do not count.
    products : collection of str
        Paths of the products.
    """
    found = []
    for above, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".") and name not in NOT_PRODUCTS]
        paths = (Path(above, name) for name in files if not name.startswith(".") and name not in NOT_PRODUCTS)
        found += [path.relative_to(folder).as_posix() for path in paths if path.as_posix() not in products]
    return sorted(found)
