"""Records added to a campaign: their files in its raw folder, their checksums, a line of its CSV for each.

example:
  freerock add marble_2026 /media/usb/monday/*.tdms --block tall --foundation mat

Copies the files to the raw folder, lists their checksums in manifest.csv, and appends a line for
each to the campaign's CSV. Adds all files or none. Each test has the name of its file. If the
campaign has only one block, foundation or laser, omit the option.
"""

import csv
import io
import re
from argparse import Namespace
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from freerock.cli.inspect_command import ChannelLook, RecordLook, look_text, looks_to_take, take
from freerock.cli.new_campaign_command import plain_name, proposed
from freerock.config.campaign import Source, campaign_paths, read_campaign
from freerock.config.lasers import LaserSection
from freerock.config.mistakes import refuse
from freerock.config.record import rows_in
from freerock.config.values import did_you_mean
from freerock.errors import FreerockError, attempt
from freerock.files import CHECKSUM_COLUMNS, MANIFEST, atomic, listed_checksums, sha256, write_bytes
from freerock.rotation.channel import CHECK, NO_NUMBER
from freerock.rotation.sensor import recorded_of

CELLS = ("channel", "block", "foundation", "laser")  # the same for all files of a command
Row = dict[str, str]


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("name", metavar="NAME", help="name of the campaign")
    add("files", metavar="FILE", nargs="+", help="record files")
    add("--block", default="", help="the block of these records")
    add("--foundation", default="", help="their foundation")
    add("--laser", default="", help="their laser, or two lasers as a;b")
    add("--channel", default="", help="the channel of the laser, or of two lasers as a;b")


def run(chosen: Namespace) -> None:
    """Add records; print what is in them and what was written.

    All files are read, and all lines checked, before anything is written.

    Raises
    ------
    ConfigError
        The campaign has mistakes; a file can't be read, its name or content is there already, or what is
        requested does not fit: a line for each.
    FreerockError
        Something can't be written.
    """
    problems: list[FreerockError] = []
    paths = campaign_paths("config/config.yaml", [chosen.name], problems)
    source = read_campaign(paths[0]) if paths else None
    refuse([*problems, *(source.problems if source else ())])
    assert source and source.campaign
    cells = _cells(source, {cell: getattr(chosen, cell) for cell in CELLS})
    known = source.campaign.processing.rotation
    looks, refused = looks_to_take(chosen.files, known.time_unit, known.sampling_rate_hz)
    refuse(refused)
    raw, table, rows = Path(source.raw), source.path.with_suffix(".csv"), list[Row]()
    for look in looks:
        row = attempt(_row, look, looks, cells, source)
        refused += [row] if isinstance(row, FreerockError) else []
        rows += [row] if isinstance(row, dict) else []
    refuse(refused)
    content = _appended(table.read_bytes(), table, rows)
    refuse(read_campaign(source.path, content).problems)
    for look, row in zip(looks, rows, strict=True):
        if not (raw / row["file"]).exists():
            with atomic(raw / row["file"]) as partial:
                take(look, partial)
    _list_checksums(raw, looks, rows)
    write_bytes(table, content)
    print("\n\n".join(map(look_text, looks)), end="\n\n")
    for row in rows:
        print(f"added: {', '.join(row[cell] for cell in ('test', 'file', *CELLS) if row[cell])}")
    print(f"next:  freerock check {chosen.name}")


def _list_checksums(raw: Path, looks: Sequence[RecordLook], rows: Sequence[Row]) -> None:
    """Append what manifest.csv of the raw folder lacks."""
    manifest, listed = raw / MANIFEST, listed_checksums(raw)
    new = [
        {"file": row["file"], "sha256": look.sha256, "bytes": str(look.n_bytes)}
        for look, row in zip(looks, rows, strict=True)
        if row["file"] not in listed
    ]
    before = manifest.read_bytes() if manifest.exists() else (",".join(CHECKSUM_COLUMNS) + "\n").encode()
    write_bytes(manifest, _appended(before, manifest, new))


def _cells(source: Source, wanted: Mapping[str, str]) -> Row:
    """The cells of all lines: those requested, else the only ones."""
    assert source.campaign
    problems, cells = [], dict(wanted)
    for column in ("block", "foundation", "laser"):
        known = list(getattr(source.campaign, f"{column}s"))
        cells[column] = wanted[column] or known[0]
        for each in map(str.strip, cells[column].split(";")):
            if each not in known:
                remedy = did_you_mean(each, known) or f"use one of {', '.join(known)}"
                what = f"{each!r} is not a {column} of {source.path}"
                problems.append(FreerockError(f"--{column}", what, remedy))
        if not wanted[column] and len(known) > 1:
            what = f"has the {column}s {', '.join(known)}"
            problems.append(FreerockError(source.path, what, f"say which with --{column}"))
    refuse(problems)
    return cells


def _row(look: RecordLook, looks: Sequence[RecordLook], cells: Mapping[str, str], source: Source) -> Row:
    """The cells of a line; raises what speaks against it."""
    raw, path, test = Path(source.raw).resolve(), look.path.resolve(), plain_name(look.path.stem)
    file = path.relative_to(raw).as_posix() if path.is_relative_to(raw) else path.name
    for what, remedy in _faults(look, file, test, looks, source):
        raise FreerockError(look.path, what, remedy)
    return {"test": test, "file": file, **cells, "channel": _channel(look, cells, source)}


def _faults(
    look: RecordLook, file: str, test: str, looks: Sequence[RecordLook], source: Source
) -> Iterator[tuple[str, str]]:
    """Why a file can't be added under a name, and what to do."""
    raw, table = Path(source.raw), source.path.with_suffix(".csv")
    for other in looks[: looks.index(look)]:
        if other.sha256 == look.sha256:
            yield f"has the content of {other.path}", "leave one of them out"
        if plain_name(other.path.stem).casefold() == test.casefold():
            yield f"its test would be called {test}, as that of {other.path}", "rename the file"
    listed = listed_checksums(raw)
    for line, record in source.records:
        there = raw / record.file
        if listed.get(record.file) == look.sha256 or (
            there.is_file() and there.stat().st_size == look.n_bytes and sha256(there) == look.sha256
        ):
            yield f"has the content of {there}, which is on line {line} of {table} already", "leave it out"
        if record.test.casefold() == test.casefold():
            yield f"its test would be called {test}, as that on line {line} of {table}", "rename the file"
    if (raw / file).exists() and sha256(raw / file) != look.sha256:
        yield f"{raw / file} exists already and is another file", "rename the file"
    if listed.get(file, look.sha256) != look.sha256:
        yield f"{raw / MANIFEST} lists another file of that name", "rename the file"


def _channel(look: RecordLook, cells: Mapping[str, str], source: Source) -> str:
    """The cell of the channels: as requested, else the only one that may be the laser's."""
    lasers = [name.strip() for name in cells["laser"].split(";")]
    names = {channel.name: channel for channel in look.channels}
    first = source.lasers[lasers[0]]
    fitting = [name for name, each in names.items() if not _fault(first, each)]
    fitting = fitting or [channel.name for channel in proposed(look)] or [*look.faults]
    wanted = [name.strip() for name in cells["channel"].split(";")] if cells["channel"] else fitting
    for name in wanted:
        if error := look.faults.get(name):
            raise FreerockError(f"{look.path}: channel {name}", error.what, error.remedy)
        if name not in names:
            what = f"no channel {name!r} that can be read; its channels are {', '.join(names)}"
            raise FreerockError(look.path, what, "correct --channel")
    if len(wanted) != len(lasers):
        what = f"has the channels {', '.join(names)}"
        raise FreerockError(look.path, what, "say which with --channel, those of two lasers as a;b")
    for laser, name in zip(lasers, wanted, strict=True):
        if error := _fault(source.lasers[laser], names[name]):
            where = f"{look.path}: channel {name} of laser {laser}"
            raise FreerockError(where, error.what, error.remedy)
    return "" if len(look.channels) + len(look.faults) == 1 else ";".join(wanted)


def _fault(laser: LaserSection, channel: ChannelLook) -> FreerockError | None:
    """Why a channel can't be the laser's."""
    found = attempt(recorded_of, [], laser, channel.units)
    if not isinstance(found, FreerockError) and channel.n_missing == channel.n_samples:
        return FreerockError("laser signal", NO_NUMBER, CHECK)
    return found if isinstance(found, FreerockError) else None


def _appended(content: bytes, table: Path, rows: Sequence[Row]) -> bytes:
    """The content of a CSV file with further lines, which end as its first does; its own bytes stay."""
    text = content.decode()
    header = rows_in(text.removeprefix("\ufeff"), table)[0][1]
    end = (re.search(r"\r\n|\n|\r", text) or ["\n"])[0]
    out = io.StringIO(newline="")
    csv.DictWriter(out, header, extrasaction="ignore", lineterminator=end).writerows(rows)
    return content + (b"" if text.endswith(("\n", "\r")) else end.encode()) + out.getvalue().encode()
