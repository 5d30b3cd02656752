"""Campaigns: YAML and CSV files in, checked campaigns out.

All problems of all files are reported at once, one line each: file and line, key, what is wrong, what to do.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from freerock.config import values
from freerock.config.campaign_file import CampaignFile
from freerock.config.lasers import LaserSection
from freerock.config.mistakes import refuse, validate
from freerock.config.record import Record, read_records
from freerock.config.values import Name, Section, key
from freerock.config.yaml_lines import Lines, place, read_yaml
from freerock.errors import FreerockError

OPTIONS = ("campaigns",)  # of snakemake --config
RESERVED = ("studies", "inspect")  # folders of results that are no campaign's


class Campaign(CampaignFile):
    """A campaign as loaded: its YAML file and the records of its CSV file."""

    name: Name = key("the name of the campaign")
    records: tuple[Record, ...] = key("the records")

    __hash__ = object.__hash__  # a campaign is the key of what is made of it once

    def record(self, test: str) -> Record:
        """The record of a test."""
        return next(record for record in self.records if record.test == test)

    def file(self, test: str) -> str:
        """Path of the record file of a test."""
        return f"{self.raw}/{self.record(test).file}"


class ConfigFile(Section):
    """What is analysed: config/config.yaml."""

    campaigns: tuple[Name, ...] = key(
        "the campaigns to analyse, as a list of names in config/campaigns", min_length=1
    )


def load_config(
    path: str | Path = "config/config.yaml", campaigns: str | Sequence[str] | None = None
) -> dict[str, Campaign]:
    """Read and check config.yaml and the campaigns it names.

    Parameters
    ----------
    path : path
        The configuration file; campaigns lie in the folder `campaigns` beside it.
    campaigns : sequence of str, or str with commas, optional
        Names that replace those of the file, which then is not read.

    Returns
    -------
    dict of str to Campaign
        By name, in their order.

    Raises
    ------
    ConfigError
        All problems of all files.

    Examples
    --------
    >>> campaign = load_config("config/config.yaml", ["palermo_virtual"])["palermo_virtual"]
    >>> len(campaign.records), [*campaign.blocks]
    (6, ['config1', 'config2', 'config3'])
    """
    problems: list[FreerockError] = []
    sources = [read_campaign(each) for each in campaign_paths(path, campaigns, problems)]
    refuse([*problems, *(problem for source in sources for problem in source.problems)])
    return {source.path.stem: source.campaign for source in sources if source.campaign}


def load_campaign(path: str | Path, table: bytes | None = None) -> Campaign:
    """Read and check one campaign: its YAML file and the CSV file of the same name beside it.

    Parameters
    ----------
    path : path
        The YAML file.
    table : bytes, optional
        Content of the CSV file, if not the present one.

    Raises
    ------
    ConfigError
        All problems of both files.

    Examples
    --------
    >>> load_campaign("config/campaigns/palermo_virtual.yaml").origin
    'simulated'
    """
    source = read_campaign(path, table)
    refuse(source.problems)
    assert source.campaign
    return source.campaign


def campaign_paths(
    path: str | Path, campaigns: str | Sequence[str] | None, problems: list[FreerockError]
) -> list[Path]:
    """YAML files of the campaigns to analyse; arguments as of `load_config`, adds the problems it meets."""
    path = Path(path)
    if campaigns is None:
        data, lines, found = read_yaml(path)
        where = place(path, lines, ("campaigns",))
    else:
        where = "campaigns"
        names = campaigns if isinstance(campaigns, list | tuple) else str(campaigns).split(",")
        data, lines, found = {"campaigns": [*map(str, names)]}, {}, []
    file = validate(ConfigFile, data, lambda loc: place(path, lines, loc), found)
    problems += found
    paths = []
    for name in dict.fromkeys(file.campaigns) if file else ():
        campaign_path = path.parent / "campaigns" / f"{name}.yaml"
        if name in RESERVED:
            problems.append(FreerockError(where, f"{name!r} is a folder of results", "rename the campaign"))
        elif campaign_path.exists():
            paths.append(campaign_path)
        else:
            others = [p.stem for p in sorted(campaign_path.parent.glob("*.yaml"))]
            what = f"there is no campaign {name!r}: {campaign_path} is missing"
            remedy = values.did_you_mean(name, others) or "write the file or correct the name"
            problems.append(FreerockError(where, what, remedy))
    return paths


def check_options(options: Iterable[str]) -> None:
    """Refuse misspelt keys of `snakemake --config`; others may be those of a workflow that uses this one.

    Raises
    ------
    FreerockError
        A key is close to one of `OPTIONS`.
    """
    for option in options:
        if option not in OPTIONS and values.closest(option, OPTIONS):
            raise FreerockError(f"--config: {option}", "unknown key", values.did_you_mean(option, OPTIONS))


@dataclass(frozen=True)
class Source:
    """What the two files of a campaign hold, as far as they can be understood.

    Parameters
    ----------
    path : Path
        The YAML file.
    campaign : Campaign or None
        Of the sound records; None where the YAML file has problems.
    lasers : dict of str to LaserSection
        Empty where the YAML file has problems.
    raw : str
        The folder of the record files.
    records : tuple of (int, Record)
        Each sound record with its line in the CSV file.
    lines : dict
        Line of each key of the YAML file.
    problems : tuple of FreerockError
    """

    path: Path
    campaign: Campaign | None
    lasers: dict[str, LaserSection]
    raw: str
    records: tuple[tuple[int, Record], ...]
    lines: Lines
    problems: tuple[FreerockError, ...]

    def where(self, *key: str) -> str:
        """file:line: key of the YAML file."""
        return place(self.path, self.lines, key)


def read_campaign(path: str | Path, table: bytes | None = None) -> Source:
    """Read the YAML file of a campaign and the CSV file beside it; never raises for what they hold.

    `table` counts in place of what the CSV file holds.
    """
    path = Path(path)
    data, lines, problems = read_yaml(path)
    file = validate(CampaignFile, data, lambda loc: place(path, lines, loc), problems)
    names = {column: (data or {}).get(f"{column}s") for column in ("block", "foundation", "laser")}
    csv = path.with_suffix(".csv")
    records = read_records(csv, names, path, problems, table) if path.exists() else []
    for line, record in records if file else ():
        for what, remedy in _laser_faults(record, file):
            problems.append(FreerockError(f"{csv}:{line}: laser", what, remedy))
    raw = str((data or {}).get("raw") or "").strip().rstrip("/") or f"raw/{path.stem}"
    sound = tuple(record for _, record in records)
    fields = {**dict(file or ()), "raw": raw, "name": path.stem, "records": sound}
    campaign = Campaign.model_construct(**fields) if file else None
    lasers = file.lasers if file else {}
    return Source(path, campaign, lasers, raw, tuple(records), lines, tuple(problems))


def _laser_faults(record: Record, file: CampaignFile) -> Iterator[tuple[str, str]]:
    """Why the lasers of a record can't watch it, and what to do."""
    known = [name for name in record.lasers if name in file.lasers]
    if len(known) == 2:
        yield from _pair_faults(*(file.lasers[name] for name in known))
    block = file.blocks.get(record.block)
    for name in known:
        at = file.lasers[name].position_m or 0.0
        if block and file.lasers[name].beam == "horizontal" and at > block.height_m:
            what = (
                f"position_m of {name} is {at:g}: above the block {record.block}, {block.height_m:g} m high"
            )
            yield what, "give the beam's height above the base in metres, or correct height_m"


def _pair_faults(one: LaserSection, other: LaserSection) -> Iterator[tuple[str, str]]:
    if one.beam is None or (one.beam, one.face) != (other.beam, other.face):
        yield "the two beams differ in kind or in face", "use two of one kind, on one face"
    elif one.position_m == other.position_m:
        yield "the two beams are at one position_m", "give both positions"
