"""Campaigns: YAML and CSV files in, checked campaigns out.

All problems of all files are reported at once, one line each: file and line, key, what is wrong, what to do.
"""

import math
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import ValidationInfo, field_validator

from freerock.config import keys, values
from freerock.config.figure_names import FIGURES, FIGURES_BY_DEFAULT, Figure
from freerock.config.laser_section import LaserSection
from freerock.config.mistakes import ConfigError, refuse, validate
from freerock.config.record import Record, read_records
from freerock.config.values import Folder, Invalid, Name, Once, Section, Text, Whole, key
from freerock.config.yaml_lines import Lines, place, read_yaml
from freerock.errors import FreerockError

OPTIONS = ("campaigns", "studies", "verify")  # of snakemake --config
RESERVED = {  # folders of results that are no campaign's
    "studies": "the results of the studies",
    "inspect": "the pictures of `freerock inspect`",
    "simulate": "the results of `freerock simulate`",
}


class CampaignFile(Section):
    """A test campaign: config/campaigns/<name>.yaml."""

    title: Text = key("the title of the campaign", min_length=1)
    origin: Literal["simulated", "measured"] = key(
        "simulated or measured, as shown in every dataset, table and figure"
    )
    summary: Text = key("what was tested, how and why, in a sentence or two", "")
    institution: Text = key("the laboratory", "")
    creator: Text = key("who made the records", "")
    license: Text = key("the licence of the records", "")
    references: Text = key("publications, as doi:10.…/…", "")
    raw: Folder = key("the folder of the record files; by default raw/<name of the campaign>", "")
    truth: str = key("the file of true values in the raw folder, of a simulated campaign", "")
    blocks: dict[Name, keys.BlockSection] = key("one or more blocks, each by its name", min_length=1)
    foundations: dict[Name, keys.FoundationSection] = key(
        "one or more foundations, each by its name", min_length=1
    )
    lasers: dict[Name, LaserSection] = key("one or more sensors, each by its name", min_length=1)
    records_per_job: Whole = key(
        "records per job, at most; with hundreds of records 40 saves start-up time", 4, ge=1
    )
    ground_motions: keys.GroundMotionsSection | None = key(
        "the ground motions under which the report says whether the blocks fall", None
    )
    figures: Annotated[tuple[Figure, ...], Once] = key(
        "the figures of the report; any other is drawn if it is the target of snakemake",
        FIGURES_BY_DEFAULT,
        validate_default=True,
    )
    figures_for: Annotated[tuple[Literal["single_column", "slide"], ...], Once] = key(
        "further targets of the figures, beside the double column of a paper", ()
    )
    processing: keys.ProcessingSection = key("the steps from volts to impacts", keys.ProcessingSection())
    fits: keys.FitsSection = key("the identification of the models", keys.FitsSection())
    published: keys.PublishedSection | None = key(
        "values of a publication, printed beside the identified ones", None
    )
    plan: keys.PlanSection | None = key("tests for which `freerock plan` predicts standard errors", None)

    @field_validator("figures")
    @classmethod
    def _in_order(cls, names: Any, info: ValidationInfo) -> Any:
        moved = info.data.get("ground_motions") is not None
        if "overturning" in names and not moved:
            raise Invalid(
                "the figure overturning needs ground motions", "give ground_motions, or remove the figure"
            )
        return tuple(sorted({*names, *(["overturning"] if moved else [])}, key=FIGURES.index))

    @field_validator("blocks", "foundations")
    @classmethod
    def _labelled(cls, sections: Any, info: ValidationInfo) -> Any:
        first: dict[str, str] = {}  # name of each label
        for name, section in sections.items():
            if info.field_name == "foundations" and name in info.data.get("blocks", ()):
                raise Invalid(f"{name!r} is the name of a block already", "rename one of the two")
            other = first.setdefault(section.label or name, name)
            if other != name:
                what = f"{other!r} and {name!r} are both printed as {section.label or name!r}"
                raise Invalid(what, "give each its own label")
        return {name: s if s.label else s.model_copy(update={"label": name}) for name, s in sections.items()}

    @field_validator("truth")
    @classmethod
    def _truth_is_simulated(cls, truth: Any, info: ValidationInfo) -> Any:
        if truth and info.data.get("origin") == "measured":
            raise Invalid("a measured campaign has no known truth", "remove the key or set origin: simulated")
        return values.check_inside(truth) if truth else truth

    @field_validator("published")
    @classmethod
    def _published_is_configured(cls, published: Any, info: ValidationInfo) -> Any:
        if published is None:
            return published
        longest = ((block, [foundation]) for block, foundation in published.longest.items())
        for block, foundations in (*published.values.items(), *longest):
            values.check_name(block, info.data.get("blocks", (block,)), "a block of this campaign")
            for name in foundations:
                values.check_name(
                    name, info.data.get("foundations", (name,)), "a foundation of this campaign"
                )
        return published

    @field_validator("plan")
    @classmethod
    def _plan_is_configured(cls, plan: Any, info: ValidationInfo) -> Any:
        if plan is None or not {"blocks", "foundations"} <= info.data.keys():
            return plan
        blocks, foundations = info.data["blocks"], info.data["foundations"]
        for name in (*plan.expected, *plan.spread_fraction):
            values.check_name(name, foundations, "a foundation of this campaign")
        for name in foundations:
            if name not in plan.expected:
                raise Invalid(f"no parameters are expected of foundation {name!r}", "add it to plan.expected")
        for name, angles in plan.release_angles_deg.items():
            values.check_name(name, blocks, "a block of this campaign")
            critical = math.degrees(blocks[name].block.theta_cr)
            if max(angles, default=0) >= critical:
                what = f"released at {max(angles):g}° {name} overturns, its critical angle is {critical:.3f}°"
                raise Invalid(what, "plan for smaller angles")
        for name, block in blocks.items():
            if not (plan.release_angles_deg.get(name) or block.release_angle_deg):
                raise Invalid(f"block {name!r} has no release angle", "add it to plan.release_angles_deg")
        return plan


class Campaign(CampaignFile):
    """A campaign as loaded: its YAML file and the records of its CSV file."""

    name: Name = key("the name of the campaign")
    records: tuple[Record, ...] = key("the records")

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
) -> "Config":
    """Read and check config.yaml and the campaigns it names.

    Parameters
    ----------
    path : path
        The configuration file; campaigns lie in the folder `campaigns` beside it.
    campaigns : sequence of str, or str with commas, optional
        Names that replace those of the file, which then is not read.

    Returns
    -------
    Config

    Raises
    ------
    ConfigError
        All problems of all files.
    """
    problems: list[FreerockError] = []
    sources = [read_campaign(each) for each in campaign_paths(path, campaigns, problems)]
    refuse([*problems, *(problem for source in sources for problem in source.problems)])
    return Config({source.path.stem: source for source in sources})


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
    """
    source = read_campaign(path, table)
    if source.campaign is None:
        raise ConfigError(source.problems)
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
            problems.append(FreerockError(where, f"{name!r} names {RESERVED[name]}", "rename the campaign"))
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
        None where there are problems.
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


class Config(NamedTuple):
    """The configuration as loaded: what the files of each campaign hold, by its name."""

    sources: dict[str, Source]

    @property
    def campaigns(self) -> dict[str, Campaign]:
        """The campaigns by their names."""
        return {name: each.campaign for name, each in self.sources.items() if each.campaign}


def read_campaign(path: str | Path, table: bytes | None = None) -> Source:
    """Read the YAML file of a campaign and the CSV file beside it; never raises for what they hold.

    `table` counts in place of what the CSV file holds.
    """
    path = Path(path)
    data, lines, problems = read_yaml(path)
    file = validate(CampaignFile, data, lambda loc: place(path, lines, loc), problems)
    if fault := values.name_fault(path.stem):  # no such file can be written either
        problems = [*(problems if os.path.exists(path) else ()), FreerockError(path, *fault)]
    names = {column: (data or {}).get(f"{column}s") for column in ("block", "foundation", "laser")}
    csv = path.with_suffix(".csv")
    there = os.path.exists(path)  # not, either, with a name that is too long
    records = read_records(csv, names, path, problems, table) if there else []
    for line, record in records if file else ():
        for what, remedy in _laser_faults(record, file):
            problems.append(FreerockError(f"{csv}:{line}: laser", what, remedy))
    raw = str((data or {}).get("raw") or "").strip().rstrip("/") or f"raw/{path.stem}"
    campaign = None
    if file and not problems:
        fields = {**dict(file), "raw": raw, "name": path.stem}
        campaign = Campaign.model_construct(**fields, records=tuple(record for _, record in records))
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
            yield what, "give the beam's height above the base in metres"


def _pair_faults(one: LaserSection, other: LaserSection) -> Iterator[tuple[str, str]]:
    if one.beam is None or (one.beam, one.face) != (other.beam, other.face):
        yield "the two beams differ in kind or in face", "use two of one kind, on one face"
    elif one.position_m == other.position_m:
        yield "the two beams are at one position_m", "give both positions"
