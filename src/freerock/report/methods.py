"""What was done in a campaign, in paragraphs that a paper can take over, with citations."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from freerock.config.input_uncertainties import DEFAULTS
from freerock.models.block import GRAVITY
from freerock.models.laws import LAWS
from freerock.populations.priors import RECORDS, RUNS
from freerock.tables.markdown import SIGNS

PAGE_FILES = Path(__file__).parent
_ENTRY = re.compile(r"^Cited as (.+)\n(@(?:article|book|misc)\{(\w+),\n(?:  .+\n)+\}\n)", re.M)


class Reference(NamedTuple):
    """A publication: how a text calls it, by authors and year, and its entry in BibTeX."""

    short: str
    entry: str

    @property
    def doi(self) -> str:
        """Its DOI."""
        return self.entry.partition("  doi = {")[2].partition("}")[0]


_FILE = (PAGE_FILES / "references.bib").read_text(encoding="utf-8")
REFERENCES = {key: Reference(short, entry) for short, entry, key in _ENTRY.findall(_FILE)}
assert len(REFERENCES) == _FILE.count("\n@"), "references.bib: an entry was passed over"
ASSUMED = (
    f"{1e3 * DEFAULTS['height_m']:g} mm (lengths of a block), {100 * DEFAULTS['mass_fraction']:g} % (mass), "
    f"{100 * DEFAULTS['inertia_fraction']:g} % (inertia), {1e3 * DEFAULTS['position_m']:g} mm (beam), "
    f"{100 * DEFAULTS['scale_fraction']:g} % (scale), {DEFAULTS['response_ms']:g} ms (response), "
    f"{1e6 * DEFAULTS['sampling_rate_fraction']:g} ppm (sampling rate)"
)
_KEY = f"@(?:{'|'.join(REFERENCES)})"
CITED = re.compile(rf"\[({_KEY}(?:; {_KEY})*)\]")
PLAIN = SIGNS | {ord("@"): "\\@"}  # in Markdown, where @ begins a citation
_TEMPLATES = Environment(loader=FileSystemLoader(PAGE_FILES), undefined=StrictUndefined)
_HEAD = re.compile(r"^## (.+)$", re.M)  # of methods.j2


class Paragraph(NamedTuple):
    """A paragraph: its head, and its text with citations as [@key; @key]."""

    head: str
    text: str


def methods(
    config: Mapping[str, Any], rates_hz: Sequence[float], software: Mapping[str, str], git: str
) -> list[Paragraph]:
    """The methods of a campaign, with its settings.

    Parameters
    ----------
    config : mapping
        The campaign's section.
    rates_hz : sequence of float
        Sampling rates of the records.
    software : mapping of str to str
        Versions by name.
    git : str
        State of the code.
    """
    rates = sorted(set(rates_hz))
    text = _TEMPLATES.get_template("methods.j2").render(
        {"config": config, "software": software, "git": git},
        rates_hz=" to ".join(dict.fromkeys(f"{rate:.6g}" for rate in (*rates[:1], *rates[-1:]))),
        laws={model: LAWS[model] for model in config["fits"]["models"]},
        gravity=_gravity(config["blocks"]),
        assumed=ASSUMED,
        priors={"runs": RUNS, "records": RECORDS},
    )
    _, *parts = _HEAD.split(text)
    told = {
        head: re.sub("[ \n]+", " ", body).strip() for head, body in zip(parts[::2], parts[1::2], strict=True)
    }
    return [Paragraph(head, text) for head, text in told.items() if text]


def _gravity(blocks: Mapping[str, Mapping[str, Any]]) -> dict[float, list[str]]:
    """The acceleration of gravity [m/s²] with the labels of the blocks that rocked there."""
    found: dict[float, list[str]] = {}
    for name, block in blocks.items():
        found.setdefault(block.get("gravity_m_s2") or GRAVITY, []).append(block.get("label", name))
    return found


def cited(paragraphs: Sequence[Paragraph]) -> list[str]:
    """Keys of what paragraphs cite, in their order."""
    found = (key for each in paragraphs for group in CITED.findall(each.text) for key in group.split("; "))
    return list(dict.fromkeys(key.removeprefix("@") for key in found))


def methods_markdown(paragraphs: Sequence[Paragraph]) -> str:
    """Paragraphs in Markdown with citations as pandoc reads them, and the references below."""
    texts = [f"**{each.head}.** {_escaped(each.text)}" for each in paragraphs]
    listed = [f"- @{key}: doi:{REFERENCES[key].doi}" for key in cited(paragraphs)]
    return "\n\n".join([*texts, "\n".join(listed)]) + "\n"


def _escaped(text: str) -> str:
    """A text in which nothing but its citations is Markdown's."""
    parts = CITED.split(text)
    return "".join(f"[{part}]" if i % 2 else part.translate(PLAIN) for i, part in enumerate(parts))


def html(paragraph: Paragraph) -> Markup:
    """A paragraph's text with citations as "(Housner 1963)"."""

    def short(match: re.Match[str]) -> str:
        return f"({'; '.join(REFERENCES[key.removeprefix('@')].short for key in match[1].split('; '))})"

    return escape(CITED.sub(short, paragraph.text))


def bib(paragraphs: Sequence[Paragraph]) -> str:
    """BibTeX of what paragraphs cite."""
    return "\n".join(REFERENCES[key].entry for key in cited(paragraphs))
