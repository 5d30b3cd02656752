"""Whether a campaign is ready: its configuration, record files, channels, calibrations, checksums, units."""

from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from freerock.cli.plausible import doubts_about
from freerock.config.campaign import Source, campaign_paths, read_campaign
from freerock.config.mistakes import ConfigError
from freerock.config.record import Record
from freerock.config.sensor import LaserSection
from freerock.errors import FreerockError
from freerock.files import check_manifest, listed_checksums
from freerock.units import in_base_units
from freerock.virtual_lab.truth import read_truth

if TYPE_CHECKING:
    from freerock.records.channels import Channel
    from freerock.rotation.calibration import Calibration

    Contents = dict[str, Channel] | FreerockError

NAME_IT = "name one in the channel column of the campaign's CSV"


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    parser.epilog = (
        "example:\n"
        "  freerock check palermo_virtual\n"
        "\n"
        "Shows every mistake of the configuration at once, and whether record files, channels, units,\n"
        "calibrations and checksums are as it says. What can be and hardly is (angles in radians, time in\n"
        "milliseconds, a signal that sweeps no angle of a rocking block) is printed as a doubt and stops\n"
        "nothing. Nothing is written."
    )
    parser.add_argument(
        "campaign",
        metavar="CAMPAIGN",
        nargs="?",
        help="its name or YAML file; left out, the campaigns of config/config.yaml",
    )


def run(chosen: Namespace) -> None:
    """Print doubts and what is sound; raise all problems together."""
    sound, problems, doubts = check_config(campaign=chosen.campaign)
    for doubt in doubts:
        print(f"doubt: {doubt}")
    for line in sound:
        print(f"{line}: nothing to correct")
    if problems:
        raise ConfigError(problems)


def check_config(
    path: str | Path = "config/config.yaml", campaign: str | None = None
) -> tuple[list[str], list[FreerockError], list[FreerockError]]:
    """Check the campaigns of a configuration, or one of them.

    Parameters
    ----------
    path : path
        The configuration file; campaigns lie in the folder `campaigns` beside it.
    campaign : str, optional
        Name of the one campaign, or path of its YAML file.

    Returns
    -------
    sound : list of str
        A line for each campaign without a problem.
    problems : list of FreerockError
        All problems of all files.
    doubts : list of FreerockError
        What is possible and unusual in the campaigns without a problem.
    """
    problems: list[FreerockError] = []
    doubts: list[FreerockError] = []
    if campaign is not None and campaign.endswith((".yaml", ".yml")):
        paths = [Path(campaign)]
    else:
        paths = campaign_paths(path, None if campaign is None else [campaign], problems)
    sound = []
    for each in paths:
        source = read_campaign(each)
        found = [*source.problems, *check_files(source)]
        problems += found
        if not found and source.campaign:
            parts = [("records", source.records), ("blocks", source.campaign.blocks)]
            parts += [("foundations", source.campaign.foundations)]
            sound.append(f"{each.stem}: {', '.join(f'{len(held)} {what}' for what, held in parts)}")
            doubts += doubts_about(source)
    return sound, problems, doubts


def check_files(source: Source) -> Iterator[FreerockError]:
    """Problems of the files that a campaign names, and of its manifest."""
    if not Path(source.raw).is_dir():
        yield FreerockError(source.where("raw"), f"there is no folder {source.raw}", "put the records there")
        return
    yield from _manifest(source.raw)
    tables: dict[str, Calibration] = {}
    for name, laser in source.lasers.items():
        if laser.calibration:
            from freerock.rotation.calibration import read_calibration

            try:
                tables[name] = read_calibration(Path(source.raw, laser.calibration))
            except FreerockError as error:
                yield _at(source.where("lasers", name, "calibration"), error)
    if source.campaign and source.campaign.truth:
        try:
            read_truth(Path(source.raw, source.campaign.truth))
        except FreerockError as error:
            yield _at(source.where("truth"), error)
    csv = source.path.with_suffix(".csv")
    contents: dict[Path, Contents] = {}
    for line, record in source.records:
        path = Path(source.raw, record.file)
        if path not in contents:
            contents[path] = _contents(path)
        yield from _record(f"{csv}:{line}", path, contents[path], record, source.lasers, tables)


def _manifest(raw: str) -> Iterator[FreerockError]:
    try:
        listed: Iterable[str] = listed_checksums(raw)
    except FreerockError as error:
        yield error
        return
    for file in listed:
        try:
            check_manifest(raw, [file])
        except FreerockError as error:
            yield error


def _contents(path: Path) -> "Contents":
    """The channels of a record file, or why they can't be listed."""
    from freerock.records.read import list_channels

    try:
        return list_channels(path)
    except FreerockError as error:
        return error


def _record(
    where: str,
    path: Path,
    contents: "Contents",
    record: Record,
    lasers: dict[str, LaserSection],
    tables: "dict[str, Calibration]",
) -> Iterator[FreerockError]:
    from freerock.records.channels import chosen, listed

    if isinstance(contents, FreerockError):
        yield _at(f"{where}: file", contents)
        return
    for channel, name in zip(record.channels, record.lasers, strict=False):
        try:
            found = chosen(path, contents, channel or None)
        except FreerockError as error:
            yield _at(f"{where}: channel", error)
            continue
        if len(found) > 1:
            yield FreerockError(f"{where}: channel", f"{path}: has the channels {listed(found)}", NAME_IT)
            continue
        (unit,) = (each.units for each in found.values())
        if name in lasers:
            yield from _unit(f"{where}: laser", unit, lasers[name], tables.get(name))


def _unit(
    where: str, stated: str, laser: LaserSection, table: "Calibration | None"
) -> Iterator[FreerockError]:
    try:
        _, quantity = in_base_units([], laser.units, stated)
    except FreerockError as error:
        yield _at(where, error)
        return
    if quantity not in ("voltage", "current"):
        return
    if not (laser.range_m or laser.sensitivity_per_mm or laser.calibration):
        remedy = "give one of range_m, sensitivity_per_mm, calibration to the laser"
        yield FreerockError(where, f"a {quantity} has no scale", remedy)
    if table and table.quantity != quantity:
        what = f"the calibration table is of a {table.quantity}, the channel of a {quantity}"
        yield FreerockError(where, what, "give the table of this sensor")


def _at(where: str, error: FreerockError) -> FreerockError:
    return FreerockError(where, f"{error.where}: {error.what}", error.remedy)
