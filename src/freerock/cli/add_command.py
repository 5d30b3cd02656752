"""Records added to a campaign: their files in its raw folder, their checksums, a line of its CSV for each.

All files are read, and all lines are checked, before anything is written. Then come the copies, the checksums
and at last the CSV. Without its line a file is no record, so a killed command leaves nothing that counts.

example:
  freerock add marble_2026 /media/usb/monday/*.tdms --block tall --foundation mat

Copies the files to the raw folder, lists their checksums in manifest.csv, and appends a line for
each to the campaign's CSV. Adds all files or none. Each test has the name of its file. If the
campaign has only one block, foundation or laser, omit the option.
"""

import csv
import io
import os
import re
from argparse import Namespace
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from freerock.cli.inspect_command import ChannelLook, RecordLook, look_text, looks_to_take, take
from freerock.cli.new_campaign_command import plain_name
from freerock.config.campaign import Source, campaign_paths, read_campaign
from freerock.config.mistakes import refuse
from freerock.config.values import did_you_mean
from freerock.errors import FreerockError, attempt
from freerock.files import CHECKSUM_COLUMNS, MANIFEST, atomic, listed_checksums, sha256
from freerock.review.csv_edit import parsed
from freerock.units import in_base_units

CELLS = ("channel", "block", "foundation", "laser")  # the same for all files of a command


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("name", metavar="NAME", help="name of the campaign")
    add("files", metavar="FILE", nargs="+", help="record files")
    add("--block", default="", help="the block of these records")
    add("--foundation", default="", help="their foundation")
    add("--laser", default="", help="their laser, or two lasers as a;b")
    add("--channel", default="", help="the channel of the laser, or of two lasers as a;b")


def run(chosen: Namespace) -> None:
    """Add records; print what is in them and what was written."""
    added = add_records(chosen.name, chosen.files, {cell: getattr(chosen, cell) for cell in CELLS})
    print("\n\n".join(map(look_text, added.looks)))
    print()
    for line, row in added.lines:
        print(f"{added.csv}:{line}: {', '.join(row[cell] for cell in ('test', 'file', *CELLS) if row[cell])}")
    print(f"written: {', '.join(map(str, [*added.copies, added.manifest, added.csv]))}")
    print(f"next:    freerock check {chosen.name}")


@dataclass(frozen=True)
class Added:
    """What was written, and what is in the files.

    Parameters
    ----------
    csv, manifest : Path
    copies : tuple of Path
        Without files that were in the raw folder already.
    lines : tuple of (int, dict)
        Number and cells of each line of the CSV.
    looks : tuple of RecordLook
    """

    csv: Path
    manifest: Path
    copies: tuple[Path, ...]
    lines: tuple[tuple[int, dict[str, str]], ...]
    looks: tuple[RecordLook, ...]


def add_records(name: str, files: Sequence[str | Path], wanted: Mapping[str, str]) -> Added:
    """Add record files to a campaign, all or none.

    Parameters
    ----------
    name : str
        Of the campaign, in the current folder.
    files : sequence of path
        The record files.
    wanted : mapping of str to str
        Channel, block, foundation and laser of all of them; "" for the only one.

    Raises
    ------
    ConfigError
        The campaign has mistakes; a file can't be read, its name or content is there already, or what is
        requested does not fit: a line for each.
    FreerockError
        Something can't be written, or was changed meanwhile.
    """
    problems: list[FreerockError] = []
    paths = campaign_paths("config/config.yaml", [name], problems)
    source = read_campaign(paths[0]) if paths else None
    refuse([*problems, *(source.problems if source else ())])
    assert source
    table = Path(os.path.realpath(source.path.with_suffix(".csv")))
    before = table.read_bytes()
    cells = _cells(source, wanted)
    looks, refused = looks_to_take(files)
    refuse(refused)
    places = _places(looks, source)
    rows = _rows(looks, places, cells, source)
    after = _appended(before, parsed(before, table).names, rows)
    lines = _checked(source, after, rows)
    manifest = Path(source.raw, MANIFEST)
    copies = [
        (look, Path(source.raw, file))
        for look, file in zip(looks, places, strict=True)
        if not Path(source.raw, file).exists()
    ]
    _write_all(copies, [_manifest(manifest, looks, places), (table, before, after)])
    made = tuple(target for _, target in copies)
    return Added(source.path.with_suffix(".csv"), manifest, made, lines, tuple(looks))


def _write_all(
    copies: Sequence[tuple[RecordLook, Path]], changes: Sequence[tuple[Path, bytes | None, bytes]]
) -> None:
    """Copy files and change others, each a path, its bytes before (None: no file) and after; all or none."""
    with ExitStack() as undo:
        for look, target in copies:
            with atomic(target) as partial:
                take(look, partial)
            undo.callback(_replace, target, None)
        for path, before, after in changes:
            if (path.read_bytes() if path.exists() else None) != before:
                raise FreerockError(path, "was changed meanwhile", "run the same command again")
            if after != before:
                _replace(path, after)
                undo.callback(_replace, path, before)
        undo.pop_all()  # all is written


def _manifest(
    path: Path, looks: Sequence[RecordLook], places: Sequence[str]
) -> tuple[Path, bytes | None, bytes]:
    """The list of checksums with further files: its path, its bytes before and after."""
    listed = listed_checksums(path.parent)
    before = path.read_bytes() if path.exists() else None
    old = before or (",".join(CHECKSUM_COLUMNS) + "\n").encode()
    header = next(csv.reader(io.StringIO(old.decode("utf-8-sig"))))
    rows = [
        {"file": file, "sha256": look.sha256, "bytes": str(look.n_bytes)}
        for look, file in zip(looks, places, strict=True)
        if file not in listed
    ]
    return path, before, _appended(old, header, rows) if rows else old


def _cells(source: Source, wanted: Mapping[str, str]) -> dict[str, str]:
    """The cells of all lines: those requested, else the only ones."""
    assert source.campaign
    problems, cells = [], dict(wanted)
    for column in ("block", "foundation", "laser"):
        known = list(getattr(source.campaign, f"{column}s"))
        given = [each.strip() for each in wanted[column].split(";")] if wanted[column] else []
        for each in given:
            if each not in known:
                remedy = did_you_mean(each, known) or f"use one of {', '.join(known)}"
                what = f"{each!r} is not a {column} of {source.path}"
                problems.append(FreerockError(f"--{column}", what, remedy))
        if not given and len(known) > 1:
            what = f"has the {column}s {', '.join(known)}"
            problems.append(FreerockError(source.path, what, f"say which with --{column}"))
        cells[column] = wanted[column] or known[0]
    refuse(problems)
    return cells


def _places(looks: Sequence[RecordLook], source: Source) -> list[str]:
    """Where each file goes, relative to the raw folder; one that is there already stays where it is."""
    raw, table = Path(source.raw), source.path.with_suffix(".csv")
    recorded = {record.file: line for line, record in reversed(source.records)}
    listed = listed_checksums(raw)
    places, problems, first = [], [], dict[str, Path]()
    for look in looks:
        inside = look.path.resolve().is_relative_to(raw.resolve())
        file = look.path.resolve().relative_to(raw.resolve()).as_posix() if inside else look.path.name
        target, same = raw / file, next((f for f in recorded if _is_content(raw / f, look)), None)
        other = first.setdefault(look.sha256, look.path)
        if other is not look.path:
            problems.append(FreerockError(look.path, f"has the content of {other}", "leave one of them out"))
        elif same or look.sha256 in {listed.get(f) for f in recorded}:
            same = same or next(f for f in recorded if listed.get(f) == look.sha256)
            what = f"has the content of {raw / same}, which is on line {recorded[same]} of {table} already"
            problems.append(FreerockError(look.path, what, "leave it out"))
        elif target.exists() and not _is_content(target, look):
            what = f"{target} exists already and is another file"
            problems.append(FreerockError(look.path, what, "rename the file"))
        elif listed.get(file, look.sha256) != look.sha256:
            what = f"{raw / MANIFEST} lists another file of that name"
            problems.append(FreerockError(look.path, what, "rename the file"))
        places.append(file)
    refuse(problems)
    return places


def _is_content(path: Path, look: RecordLook) -> bool:
    return path.is_file() and path.stat().st_size == look.n_bytes and sha256(path) == look.sha256


def _rows(
    looks: Sequence[RecordLook], places: Sequence[str], cells: Mapping[str, str], source: Source
) -> list[dict[str, str]]:
    """The cells of each line."""
    table = source.path.with_suffix(".csv")
    taken = {record.test.casefold(): f"on line {line} of {table}" for line, record in source.records}
    rows, problems = [], list[FreerockError]()
    for look, file in zip(looks, places, strict=True):
        test = plain_name(look.path.stem)
        if test.casefold() in taken:
            what = f"its test would be called {test}, as that {taken[test.casefold()]}"
            problems.append(FreerockError(look.path, what, "rename the file"))
        taken.setdefault(test.casefold(), f"of {look.path}")
        channel = attempt(_channel, look, cells, source)
        if isinstance(channel, FreerockError):
            problems.append(channel)
        else:
            rows.append({"test": test, "file": file, **cells, "channel": channel})
    refuse(problems)
    return rows


def _channel(look: RecordLook, cells: Mapping[str, str], source: Source) -> str:
    """The cell of the channels: as requested, else the only one that may be the laser's."""
    lasers = [source.lasers[name.strip()] for name in cells["laser"].split(";")]
    names = {channel.name: channel for channel in look.readable}
    wanted = [name.strip() for name in cells["channel"].split(";")] if cells["channel"] else []
    if len(lasers) > 1 and len(wanted) != len(lasers):
        raise FreerockError("--channel", f"{len(lasers)} lasers need a channel each", "name them as a;b")
    for name in wanted:
        if name not in names:
            what = f"no channel {name!r} that can be read; its channels are {', '.join(names)}"
            raise FreerockError(look.path, what, "correct --channel")
    fitting = [name for name, channel in names.items() if not _contradiction(lasers[0].units, channel)]
    if not wanted and len(names) == 1:
        wanted = list(names)
    elif not wanted and len(fitting) == 1:
        wanted = fitting
    elif not wanted:
        raise FreerockError(look.path, f"has the channels {', '.join(names)}", "say which with --channel")
    for laser, name, of in zip(lasers, wanted, cells["laser"].split(";"), strict=False):
        if error := _contradiction(laser.units, names[name]):
            where = f"{look.path}: channel {name} of laser {of.strip()}"
            raise FreerockError(where, error.what, error.remedy)
    return "" if len(look.channels) == 1 else cells["channel"] or wanted[0]


def _contradiction(declared: str, channel: ChannelLook) -> FreerockError | None:
    found = attempt(in_base_units, [], declared, channel.units)
    return found if isinstance(found, FreerockError) else None


def _appended(content: bytes, header: Sequence[str], rows: Sequence[Mapping[str, str]]) -> bytes:
    """A CSV file with further lines, which end as its first does; its own bytes stay."""
    found = re.search(rb"\r\n|\n|\r", content)
    end = found[0] if found else b"\n"
    out = io.StringIO(newline="")
    lines = csv.writer(out, lineterminator=end.decode())
    lines.writerows([row.get(column.strip(), "") for column in header] for row in rows)
    missing = b"" if content.endswith((b"\n", b"\r")) else end
    return content + missing + out.getvalue().encode()


def _checked(
    source: Source, content: bytes, rows: Sequence[dict[str, str]]
) -> tuple[tuple[int, dict[str, str]], ...]:
    """Number and cells of each new line, after the CSV as it will be has been read as any other."""
    read = read_campaign(source.path, content)
    refuse(read.problems)
    n = len(source.records)
    known, new = read.records[:n], read.records[n:]
    found = [{column: getattr(record, column) for column in rows[0]} for _, record in new]
    if known != source.records or found != [*rows]:
        what = "the new lines would not be read correctly"
        raise FreerockError(source.path.with_suffix(".csv"), what, "move the column test to the front")
    return tuple((line, row) for row, (line, _) in zip(rows, new, strict=True))


def _replace(path: Path, content: bytes | None) -> None:
    """Replace what a file holds, which keeps its rights; without content remove it."""
    if content is None:
        path.unlink(missing_ok=True)
        return
    with atomic(path) as partial:
        partial.write_bytes(content)
        if path.exists():
            partial.chmod(path.stat().st_mode)
