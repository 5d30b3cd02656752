"""What was done in a campaign, in paragraphs that a paper can take over, with citations."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from markupsafe import Markup, escape

from freerock.identification.levels import TRACE
from freerock.models.laws import LAWS
from freerock.report.references import REFERENCES, bibtex
from freerock.report.text import Pairs
from freerock.selection.choice import TELLS
from freerock.tables.markdown import SIGNS

_KEY = f"@(?:{'|'.join(REFERENCES)})"
CITED = re.compile(rf"\[({_KEY}(?:; {_KEY})*)\]")
PLAIN = SIGNS | {ord("@"): "\\@"}  # in Markdown, where @ begins a citation
LAWS_CITED = {
    "housner": "[@housner1963]",
    "winkler": "[@koh1986]",
    "hunt_crossley": "[@hunt1975; @spanos2017]",
    "hardening": "[@bandis1983]",
}


class Paragraph(NamedTuple):
    """A paragraph: its head, and its text with citations as [@key; @key]."""

    head: str
    text: str


def methods(
    config: Mapping[str, Any],
    facts: Mapping[str, Any],
    tested: str,
    free: Pairs,
    software: Mapping[str, str],
    git: str,
) -> list[Paragraph]:
    """The methods of a campaign, with its settings.

    Parameters
    ----------
    config : mapping
        The campaign's section.
    facts : mapping
        Numbers as text (`freerock.report.text.facts`).
    tested : str
        What was tested, in words.
    free : sequence of (str, str)
        Models, and what was freed besides their parameters.
    software : mapping of str to str
        Versions by name.
    git : str
        State of the code.
    """
    told = {
        "Tests": tested,
        "Rotation": " ".join(_rotation(config, facts)),
        "Runs and impacts": " ".join(_runs(config["processing"])),
        "Models": " ".join(_models(config["fits"])),
        "Identification": " ".join(_identification(config["fits"], facts, free)),
        "Choice of a model": _choice(),
        "Uncertainty": " ".join(_uncertainty(config)),
        "Software": _software(software, git),
    }
    return [Paragraph(head, text) for head, text in told.items() if text]


def cited(paragraphs: Sequence[Paragraph]) -> list[str]:
    """Keys of what paragraphs cite, in their order."""
    found = (key for each in paragraphs for group in CITED.findall(each.text) for key in group.split("; "))
    return list(dict.fromkeys(key.removeprefix("@") for key in found))


def markdown(paragraphs: Sequence[Paragraph]) -> str:
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
    return bibtex(cited(paragraphs))


def _rotation(config: Mapping[str, Any], facts: Mapping[str, Any]) -> Iterator[str]:
    rotation = config["processing"]["rotation"]
    if facts["rates_hz"]:
        yield f"The sensors were sampled at {facts['rates_hz']} Hz."
    for name, laser in config["lasers"].items():
        if laser["beam"]:
            span = f", range {laser['range_m']:g} m" if laser["range_m"] else ""
            yield f"Laser {name}: {laser['beam']} beam at {laser['position_m']:g} m{span}."
        else:
            yield f"Sensor {name}: the channel holds the rotation itself, in {laser['units']}."
    yield "Samples at the sensor's error level or out of its range were left out before any other step."
    if rotation["mains_hz"]:
        yield (
            f"Lines at the mains frequency ({rotation['mains_hz']:g} Hz) and its harmonics were removed by "
            "fitted sinusoids where they stood out of the noise."
        )
    yield (
        "The zero was taken from the phases at rest, found in windows of "
        f"{rotation['window_s']:g} s; no filter was applied."
    )
    if any(laser["beam"] for laser in config["lasers"].values()):
        yield (
            "Displacement became rotation by the exact geometry of a rectangle that turns about its lower "
            "corners. In the models the centre of the base moves up and down only; that of the rectangle "
            f"moves sideways by {facts['shift_mm']} mm at most. A beam also sees the corner sink in: the "
            "modelled rotation is what the same beam would have seen of the modelled block."
        )


def _runs(processing: Mapping[str, Any]) -> Iterator[str]:
    runs, impacts = processing["runs"], processing["impacts"]
    yield (
        f"A run begins where a block that was held at an angle, read over the last {runs['held_s']:g} s, "
        f"is let go, and ends at rest; the first {1000 * runs['finger_s']:g} ms after the release, in "
        "which the support may still touch the block, were not used in a fit."
    )
    yield (
        f"A run with fewer than {runs['min_impacts']} impacts, or more than "
        f"{100 * runs['max_flagged_fraction']:g} % of its samples left out, failed."
    )
    yield (
        "The restitution of an impact, the angular rate after it over that before, comes from the peaks "
        "before and after it by the exact motion of a rigid block [@housner1963]; peaks below "
        f"{impacts['min_amplitude_sigmas']:g} standard deviations of the noise were not used. The same "
        "estimator served measured and modelled rotations."
    )


def _models(fits: Mapping[str, Any]) -> Iterator[str]:
    named = [f"{LAWS[model].label} {LAWS_CITED.get(model, '')}".rstrip() for model in fits["models"]]
    yield f"Laws fitted: {', '.join(named)}."
    if wider := [LAWS[model].label for model in fits["models"] if LAWS[model].cases]:
        were = "were" if len(wider) > 1 else "was"
        yield f"{' and '.join(wider)} {were} fitted only if the residuals of the others exceed the noise."
    yield (
        "The foundation is a bed of independent springs and dashpots under the base, whose centre moves up "
        f"and down only [@spanos2017]. Debonding rule “{fits['debonding']}”: base and foundation are in "
        "contact wherever the base lies below the undeformed surface"
        + (
            ", as in the printed equations; a dashpot may pull there."
            if fits["debonding"] == "geometric"
            else " and the foundation pushes."
        )
    )
    if fits["kinematics"]:
        yield (
            "Variants of these laws, in which the block turns about the corner that stays down or the "
            "contact width is free, were tried where no candidate with fewer numbers explains the run."
        )


def _identification(fits: Mapping[str, Any], facts: Mapping[str, Any], free: Pairs) -> Iterator[str]:
    freed = "; ".join(f"{names}: {what}" for names, what in free)
    yield (
        "Each run was fitted by itself: the mean square of modelled minus measured rotation was minimised "
        "by a trust region [@virtanen2020], from the best points of a scan, over growing parts of the run."
    )
    yield f"Free besides the parameters of the law: {freed}{' (paper mode)' if fits['paper_mode'] else ''}."
    yield "The discrepancy is ε_θ = ∫(θ_th − θ_ex)² dt / ∫θ_ex² dt up to the end of the run [@spanos2017]."
    if facts["n_integrated"]:
        low, high = facts["rtol_low"], facts["rtol_high"]
        yield (
            f"The foundation's laws were integrated with a relative tolerance of {low}"
            f"{f' to {high}' if high != low else ''}, whose error shifts no parameter by more than "
            f"{facts['error_percent']} % of its standard error; Housner's is a closed form. The last step of "
            "each fit used every valid sample of θ(t), averaged in groups that cost no standard error more "
            "than 2 %."
        )


def _choice() -> str:
    return (
        "A candidate explains a run if its residual passes for the noise of the sensor at rest in every "
        "octave of frequency (spectra by sine tapers [@riedel1995], Fisher's F), if it shows no trace of a "
        f"number that a wider law adds ({TRACE:.1f} standard errors), and if it predicts the second half of "
        "the run from the first, and the run from the others of its record, with ε_θ below 1. "
        f"A difference of {TELLS:g} in the Bayesian information criterion [@schwarz1978] rules a candidate "
        "out, and so does a candidate that holds it as a case, has the lower criterion and is more likely by "
        f"{TELLS:g} in −2 ln L. Of the others the one with the fewest free numbers is named; the rest stand "
        "beside it as also possible. Where none explains a run, the nearest is named and called so."
    )


def _uncertainty(config: Mapping[str, Any]) -> Iterator[str]:
    yield (
        "Standard errors follow from the spectrum of the noise at rest where the residual is such noise, and "
        "are not below those of the residual's own scatter and correlation elsewhere."
    )
    if config["fits"]["profile"]:
        yield "Intervals are those of the profile likelihood."
    yield (
        "The runs of a record are a sample of a population: means of ln k, ln c, ln λ and the logit of r are "
        "those of a random-effects model, its spread after [@paule1982] and its standard error after "
        "[@hartung2001]. Total standard uncertainties add what is known of block, sensor and clock "
        "[@jcgm2008]."
    )
    scenes = {(line["foundation"], line["block"]) for line in config["records"]}
    if len(scenes) > len({foundation for foundation, _ in scenes}):
        yield (
            "Whether blocks share the parameters of a foundation was tested by the scatter between blocks "
            "against that between the runs of each block, all parameters together, each block with a spread "
            "of its own [@coombs1996; @krishnamoorthy2004]; where that is below 0.05, also by χ² of their "
            "means with the uncertainty of block, sensor and clock. Blocks differ where both are."
        )


def _software(software: Mapping[str, str], git: str) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in software.items())
    return f"{versions}, run by Snakemake [@molder2021]; state of the code: {git}."
