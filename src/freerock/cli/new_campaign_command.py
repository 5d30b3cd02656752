"""A new campaign from a folder of record files: its two configuration files and its raw folder.

What is in the files is written down. What only the laboratory knows is marked FILL_IN, which is refused until
it is filled in. Records are copied, never linked, so that nothing that happens to the folder they came from
changes a result; each copy is compared with its original by checksum.

example:
  freerock new-campaign marble_2026 --from /media/usb/marble

Copies the records to raw/NAME, lists their checksums, and writes config/campaigns/NAME.yaml and
NAME.csv. Replace each FILL_IN in these files. Existing files are never overwritten.
"""

import csv
import io
import re
import shutil
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from itertools import chain, count
from pathlib import Path

from freerock.cli.init_command import NO_CAMPAIGN
from freerock.cli.inspect_command import ChannelLook, RecordLook, draw_looks, look_text, looks_to_take, take
from freerock.config.campaign import RESERVED
from freerock.config.mistakes import FILL_IN
from freerock.config.record import Record
from freerock.config.values import LONGEST_NAME, name_fault
from freerock.errors import FreerockError, printable
from freerock.files import MANIFEST, atomic, write_manifest, write_text
from freerock.records.read import READERS
from freerock.units import CHANNEL_UNITS, understood

MOST_DRAWN = 12  # records in the picture
QUICK_LOOK = "quick_look.png"  # among the results of a campaign
Sensors = dict[tuple[str, str], str]  # name of a laser by quantity and unit


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("name", metavar="NAME", help="name of the campaign: letters, digits and _")
    add("--from", dest="folder", metavar="FOLDER", required=True, help="folder of the record files")


def run(chosen: Namespace) -> None:
    """Copy the records of a folder, write the campaign's files; print what is to be done next.

    Raises
    ------
    FreerockError
        The name can't be used, something of that name exists already, or no record can be read.
    """
    name, folder = chosen.name, Path(chosen.folder)
    raw, yaml = Path("raw", name), Path("config/campaigns", f"{name}.yaml")
    table, picture = yaml.with_suffix(".csv"), Path("results", name, QUICK_LOOK)
    in_place = _in_place(name, folder, raw)
    for path in (yaml, table, *(() if in_place else (raw,))):
        if path.exists():
            raise FreerockError(path, "exists already", "choose another name, or move it away first")
    looks, refused = _records_in(folder)
    draw_looks(looks[:MOST_DRAWN], picture)
    if not in_place:
        _copy(looks, raw)
    if not (raw / MANIFEST).exists():
        write_manifest(raw, [look.path.name for look in looks])
    sensors = _sensors(looks)
    write_text(table, _csv_text(looks, refused, sensors))
    write_text(yaml, _yaml_text(name, sensors, picture))
    named = _name_the_first(Path("config/config.yaml"), name)
    print("\n\n".join(map(look_text, looks)))
    for error in refused:
        print(f"left out: {error}", file=sys.stderr)
    print(f"\nwritten: {raw}, {table}, {yaml}, {picture}")
    if len(looks) > MOST_DRAWN:
        print(f"         The picture shows the first {MOST_DRAWN} of {len(looks)} records.")
    print(f"next:    replace each {FILL_IN} in {yaml} and {table}")
    print(f"         freerock check {name}")
    print("         snakemake" if named else f"         snakemake --config campaigns={name}")
    if not named:
        print("To analyse it with every `snakemake`, add its name to campaigns in config/config.yaml.")


def _in_place(name: str, folder: Path, raw: Path) -> bool:
    """Whether the folder is the campaign's raw folder itself; refuses a name or folder that can't be used."""
    if fault := name_fault(name):
        raise FreerockError("NAME", *fault)
    if name in RESERVED:
        raise FreerockError(name, "is a folder of results", "choose another name")
    if not folder.is_dir():
        raise FreerockError(folder, "is no folder", "name the folder of the record files")
    return raw.is_dir() and raw.samefile(folder)


def _records_in(folder: Path) -> tuple[list[RecordLook], list[FreerockError]]:
    """The record files of a folder, not of those below it, and why others can't be taken."""
    files = (path for path in sorted(folder.iterdir()) if path.suffix.lower() in READERS)
    looks, refused = looks_to_take(path for path in files if path.is_file() and path.name != MANIFEST)
    if not looks:
        remedy = refused[0].remedy if refused else f"put files of {', '.join(READERS)} there"
        why = f": {refused[0].where}: {refused[0].what}" if refused else ""
        raise FreerockError(folder, f"holds no record that can be read{why}", remedy)
    return looks, refused


def _name_the_first(path: Path, name: str) -> bool:
    """Whether config.yaml named no campaign so far, as `freerock init` writes it, and now names this one."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
    if NO_CAMPAIGN not in lines:
        return False
    lines[lines.index(NO_CAMPAIGN)] = f"campaigns: [{name}]"
    write_text(path, "\n".join([*lines, ""]))
    return True


def _copy(looks: Sequence[RecordLook], raw: Path) -> None:
    """Copies of record files, all or none."""
    try:
        for look in looks:
            with atomic(raw / look.path.name) as partial:
                take(look, partial)
    except FreerockError:
        shutil.rmtree(raw, ignore_errors=True)
        raise


def proposed(look: RecordLook) -> Sequence[ChannelLook]:
    """The channels that may be the sensor's: those with a sensor's unit, else all if none is damaged."""
    known = [channel for channel in look.channels if understood(channel.units)]
    return known or ([] if look.damaged else look.channels)


def _sensors(looks: Sequence[RecordLook]) -> Sensors:
    """Name of a laser for each quantity and unit that the records' sensors have."""
    kinds = [_kind(channel) for look in looks for channel in proposed(look)] or [("", "")]
    return {kind: f"laser{number}" for number, kind in enumerate(dict.fromkeys(kinds), 1)}


def _kind(channel: ChannelLook) -> tuple[str, str]:
    """Quantity of a channel, "" where its unit is not known, and the unit of a rotation."""
    unit = understood(channel.units) or ""
    quantity = CHANNEL_UNITS[unit][0] if unit else ""
    return quantity, unit if quantity == "rotation" else ""


def _yaml_text(name: str, sensors: Sensors, picture: Path) -> str:
    from jinja2 import StrictUndefined, Template

    text = Path(__file__).with_name("campaign.yaml.j2").read_text(encoding="utf-8")
    template = Template(text, trim_blocks=True, keep_trailing_newline=True, undefined=StrictUndefined)
    made: str = template.render(name=name, sensors=sensors, picture=picture, fill=FILL_IN)
    return made


def _csv_text(looks: Sequence[RecordLook], refused: Sequence[FreerockError], sensors: Sensors) -> str:
    out = io.StringIO()
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(Record.model_fields)
    taken: set[str] = set()
    for look in looks:
        among = proposed(look)
        told = [*map(_in_words, look.channels), *(f"{name} (cannot be read)" for name in look.faults)]
        out.write(_comment(f"{look.path.name}: {', '.join(told)}"))
        lasers = [sensors[_kind(each)] for each in among] or [FILL_IN]
        tests = [(look.path.stem, FILL_IN, lasers[0])]
        if len({(each.n_samples, each.rate_hz, each.start_s) for each in among}) > 1:  # a test each
            names = [each.name for each in among]
            tests = [(f"{look.path.stem}_{name}", name, own) for name, own in zip(names, lasers, strict=True)]
        elif len(among) == 1 and not look.damaged:
            tests = [(look.path.stem, among[0].name if len(look.channels) > 1 else "", lasers[0])]
        for test, channel, laser in tests:
            cells = [_test_name(test, taken), look.path.name, channel, "block1", "foundation1", laser]
            rows.writerow(cells + [""] * (len(Record.model_fields) - len(cells)))
    for error in refused:
        out.write(_comment(f"left out: {error}"))
    return out.getvalue()


def _comment(text: str) -> str:
    """A line of its own, whatever the names in it hold."""
    return f"# {printable(' '.join(text.split()))}\n"


def _in_words(channel: ChannelLook) -> str:
    unit = channel.units or "no unit"
    return f"{channel.name} ({unit}, {channel.rate_hz:g} Hz, {channel.duration_s:.1f} s)"


def plain_name(stem: str) -> str:
    """Name of the test of a file, from that of the file without its suffix."""
    return re.sub(r"[^A-Za-z0-9]+", "_", stem).strip("_")[: LONGEST_NAME - 5] or "test"


def _test_name(stem: str, taken: set[str]) -> str:
    plain = plain_name(stem)
    names = chain([plain], (f"{plain}_{number}" for number in count(2)))
    name = next(name for name in names if name.casefold() not in taken)
    taken.add(name.casefold())
    return name
