"""The desk: a campaign, what is open of it, corrections that are tried, and corrections that are kept."""

import os
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from threading import RLock
from typing import Any

from freerock.config.campaign import Campaign, load_campaign
from freerock.config.record import Record
from freerock.config.review_log import LOOKED_AT, Change, appended, changed, changes_in, log_of, looked_at
from freerock.config.step_settings import labels
from freerock.errors import FreerockError
from freerock.files import listed_checksums, read_bytes, write_bytes
from freerock.products.netcdf import open_fits, open_record
from freerock.review.corrections import Correction, corrected, corrected_cells, correction_of
from freerock.review.csv_edit import digest, locked, save_edits
from freerock.review.listing import analysed_lines, is_behind, listed_rows
from freerock.review.pictures import lines_of_record, means_of, run_picture
from freerock.review.reprocessing import Analysed, Bench
from freerock.review.signals import Json, Signals, signals_of

OPEN = 3  # records that stay open
LARGE_BYTES = 100_000_000  # of a record: then it alone


class Desk:
    """A campaign at the desk; `requests` says what the page may send to its methods.

    Parameters
    ----------
    name : str
        Of the campaign, in the current folder.

    Raises
    ------
    FreerockError
        The campaign is not there, or the configuration refuses it.
    """

    def __init__(self, name: str):
        self.name = name
        self.yaml = Path("config/campaigns", f"{name}.yaml")
        self.csv = self.yaml.with_suffix(".csv")
        self._files = [Path(os.path.realpath(each)) for each in (self.csv, log_of(self.csv))]
        self.results = Path("results", name)
        self._held = RLock()  # what is open is looked at and corrected in two threads
        self._open: OrderedDict[str, Analysed] = OrderedDict()
        self._signals: dict[str, Signals] = {}  # of one record
        self._as_made: set[str] = set()  # records whose products hold
        self._rows: dict[str, list[Json]] = {}
        self._saved: list[list[Change]] = []  # lines of the log, of each time
        self._tried: tuple[Any, Any] = None, None  # the last correction whose fits are all known, and these
        self.read()
        self._bench = Bench(listed_checksums(self.campaign.raw))

    def read(self) -> None:
        """Read the campaign's files again; what was open of them is forgotten."""
        if not os.path.exists(self.yaml):
            load_campaign(self.yaml)  # says so
        with locked(self.csv) as table:
            self._take(table, load_campaign(self.yaml, table), self._log())

    def _take(self, table: bytes, campaign: Campaign, log: bytes) -> None:
        """Go on with what the campaign's files hold."""
        changes = changes_in(log)
        with self._held:
            self._digest, self.campaign, self.changes = digest(table), campaign, changes
            self._listed, self._then = listed_rows(self.results), analysed_lines(self.results)
            self._open.clear()
            self._signals.clear()
            self._as_made.clear()
            self._rows = {}
            self._tried = None, None

    def again(self) -> Json:
        """Read the campaign's files again; returns the list of runs."""
        self.read()
        return self.listing()

    @property
    def read_only(self) -> str:
        """Why nothing can be kept, empty where it can."""
        for path in (self.csv, self.csv.parent):
            if not os.access(path, os.W_OK):
                return f"{path} can't be written: corrections are tried, but not kept"
        return ""

    def listing(self) -> Json:
        """The list of runs, and what the page says of the campaign."""
        looked = looked_at(self.changes)
        rows = []
        for line in self.campaign.records:
            known = self._rows.get(line.test) or self._listed.get(line.test)
            behind = line.test not in self._rows and is_behind(line, self._then.get(line.test))
            names = {"test": line.test, "block": line.block, "foundation": line.foundation}
            blank = {"run": None, "verdict": "", "reasons": "not analysed yet", "model": "", "epsilon": None}
            for row in known or [names | blank | {"excluded": line.excluded}]:
                look = looked.get((line.test, str(row["run"] or "")))
                seen = f"{look.login}, {look.time[:16].replace('T', ' ')}" if look else ""
                rows.append(row | {"behind": behind, "looked": seen})
        return {
            "campaign": self.name,
            "title": self.campaign.title,
            "simulated": self.campaign.origin == "simulated",
            "read_only": self.read_only,
            "csv": str(self.csv),
            "labels": labels(self.campaign),
            "undo": len(self._saved),
            "digest": self._digest,
            "rows": rows,
        }

    def record(self, test: str, run: int | None) -> Json:
        """What the page shows of a record and of one of its runs, as the campaign's CSV has it now."""
        line = self._line(test)
        found = self._analysed(line)
        problem = ""
        try:
            signals = self._signals_of(line)
            span, step_s = signals.span_s, signals.step_s
        except FreerockError as error:
            problem, span, step_s = str(error), (0.0, 0.0), 0.0
        return {
            "test": test,
            "file": self.campaign.file(test),
            "correction": correction_of(line),
            "cells": {key: getattr(line, key) for key in ("exclude", "override", "reason", "note")},
            "span": span,
            "step_s": step_s,
            "problem": problem,
            "current": found.fits is not None,
            **self._picture(line, found, run, means=False),
        }

    def means(self, test: str) -> Json:
        """The means of a record's runs as the campaign's CSV has it now."""
        return {"means": means_of(self._analysed(self._line(test)).fits)}

    def window(self, test: str, from_s: float, to_s: float) -> Json:
        """The signals of a record between two instants [s]."""
        line = self._line(test)
        self._analysed(line)
        return self._signals_of(line).window(from_s, to_s)

    def ahead(self, test: str) -> None:
        """Do what the first correction of a record will need."""
        line = self._line(test)
        with suppress(FreerockError):
            self._bench.rotate(self.campaign, line)

    def refit(
        self,
        test: str,
        correction: Correction,
        run: int | None,
        near_s: float | None,
        whole: bool,
        needed: Callable[[], bool] = lambda: True,
    ) -> Json:
        """The record as a correction would make it.

        Parameters
        ----------
        test : str
        correction : Correction
        run : int, optional
            Number of the run that is shown.
        near_s : float, optional
            Its release [s], which counts where corrections have changed the numbers.
        whole : bool
            Fit all runs; else only the one that is shown.
        needed : callable
            Asked now and then whether to go on.

        Raises
        ------
        FreerockError
            The configuration would refuse the correction.
        bench.Superseded
            It is no longer needed.
        """
        line = self._line(test)
        cells = corrected_cells(correction, line)
        then = corrected(line, cells)
        key = (test, tuple(sorted(cells.items())))
        known, found = self._tried
        if key != known:
            found = self._bench.analyse(self.campaign, then, None if whole else (near_s or 0.0), needed)
        with self._held:
            if key != known and whole and self._line(test) == line:  # nothing was kept meanwhile
                self._tried = key, found
                if not cells:
                    self._keep(test, found)
        picture = self._picture(then, found, run, near_s, means=whole or key == known)
        return {"cells": cells, "rows": lines_of_record(test, found), **picture}

    def keep(self, corrections: Mapping[str, Correction], known: str, why: str) -> Json:
        """Write corrections into the campaign's CSV: those cells that they change, and nothing else.

        Parameters
        ----------
        corrections : mapping of str to Correction
            By test.
        known : str
            Digest of the CSV as the page knows it.
        why : str
            Why, for the log; left out, the reason of each record.

        Raises
        ------
        FreerockError
            No reason is given; somebody changed the CSV meanwhile; a file can't be written.
        """
        lines = []
        for test, correction in corrections.items():
            line = self._line(test)
            cells = corrected_cells(correction, line)
            own = why or correction.reason
            for column, value in cells.items():
                if not own:
                    raise FreerockError(f"{test}: {column}", "is changed without a reason", "say why")
                lines.append(changed(test, column, getattr(line, column), value, own))
        if lines:
            self._write(lines, known)
            self._saved.append(lines)
        return self.listing()

    def undo(self) -> Json:
        """Take back what was kept last: the cells hold again what they held before."""
        if not self._saved:
            raise FreerockError("undo", "nothing was saved since the desk was opened", "correct the fields")
        last = self._saved[-1]
        back = [changed(each.test, each.cell, each.after, each.before, "undone") for each in last]
        now = {each.test: each for each in self.campaign.records}
        moved = next((each for each in last if getattr(now[each.test], each.cell) != each.after), None)
        if moved:
            what = f"{moved.cell} of {moved.test} was changed since"
            raise FreerockError("undo", what, "correct the field instead")
        self._write(back, self._digest)
        self._saved.pop()
        return self.listing()

    def look(self, test: str, run: int | None, seen: bool) -> Json:
        """Note in the log that a run was looked at, or that it was not."""
        if self.csv.exists() and self.read_only:
            raise FreerockError(self.csv, "can't be written", "allow writing to the folder")
        number = str(run or "")
        was = (self._line(test).test, number) in looked_at(self.changes)
        if was != seen:
            words = ("yes" if was else "", "yes" if seen else "")
            with locked(self.csv):
                log = appended(self._log(), [changed(test, LOOKED_AT, *words, "", number)])
                write_bytes(self._files[1], log)
            self.changes = changes_in(log)
        return self.listing()

    def _write(self, lines: Sequence[Change], known: str) -> None:
        """Change the CSV and the log together, if the configuration takes the CSV as it will be."""
        edits = [(each.test, each.cell, each.after) for each in lines]
        campaign, log = self.campaign, b""

        def beside(made: bytes) -> dict[Path, bytes]:
            nonlocal campaign, log
            campaign, log = load_campaign(self.yaml, made), appended(self._log(), lines)
            return {self._files[1]: log}

        made = save_edits(self.csv, known, edits, beside)
        with self._held:
            touched = {each.test for each in lines}
            rows = {test: own for test, own in self._rows.items() if test not in touched}
            self._take(made, campaign, log)
            self._rows = rows

    def _log(self) -> bytes:
        """What the log holds."""
        return read_bytes(self._files[1]) if self._files[1].exists() else b""

    def _line(self, test: str) -> Record:
        for line in self.campaign.records:
            if line.test == test:
                return line
        raise FreerockError(self.csv, f"there is no record {test!r}", "read the file again")

    def _analysed(self, line: Record) -> Analysed:
        """The products of a record; what is not there or made otherwise is made, but for the fits."""
        with self._held:
            if line.test not in self._open:
                found = self._products_of(line)
                if found is not None:
                    self._as_made.add(line.test)
                self._keep(line.test, found or self._bench.process(self.campaign, line), listed=found is None)
            self._open.move_to_end(line.test)
            return self._open[line.test]

    def _products_of(self, line: Record) -> Analysed | None:
        """What the last `snakemake` made of a record, where it would be made so again."""
        with suppress(FreerockError):
            record = open_record(self._record_file(line), samples=False)
            fits = open_fits(self.results / f"fits/{line.test}.nc")
            if all(
                self._bench.is_current(self.campaign, line, tree, step)
                for step, tree in enumerate((record, fits))
            ):
                return Analysed(record, fits)
        return None

    def _keep(self, test: str, found: Analysed, listed: bool = True) -> None:
        large = found.fits is not None and found.fits.nbytes > LARGE_BYTES
        while self._open and (large or len(self._open) >= OPEN):
            self._open.popitem(last=False)
        self._open[test] = found
        if listed:
            self._rows[test] = lines_of_record(test, found)

    def _signals_of(self, line: Record) -> Signals:
        """The record over time: as processed, else its rotation, else its channels as in the file."""
        with self._held:
            if line.test not in self._signals:
                self._signals.clear()
                made = None
                if line.test in self._as_made:
                    made = open_record(self._record_file(line)).to_dataset()
                if made is None or "time" not in made:
                    made = self._bench.signals(self.campaign, line)
                self._signals[line.test] = signals_of(made)
            return self._signals[line.test]

    def _record_file(self, line: Record) -> Path:
        return self.results / f"records/{line.test}.nc"

    def _picture(
        self, line: Record, found: Analysed, run: int | None, near_s: float | None = None, means: bool = True
    ) -> Json:
        """The runs of a record, and the picture of one: the nearest, the one requested, or the first."""
        runs = lines_of_record(line.test, found)
        numbers = {row["run"]: row["release_s"] for row in runs if row["run"] is not None}
        shown = run if run in numbers else next(iter(numbers), None)
        if near_s is not None and numbers:
            shown = min(numbers, key=lambda each: abs(numbers[each] - near_s))
        block = self.campaign.blocks[line.block].block
        return {
            "runs": runs,
            "failure": runs[0]["reasons"] if shown is None else "",
            "picture": None if shown is None else run_picture(found, shown, block, means),
        }
