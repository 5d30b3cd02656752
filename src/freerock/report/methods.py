"""What was done in a campaign, in paragraphs that a paper can take over, with citations."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from markupsafe import Markup, escape

from freerock.identification.levels import REJECTS, TRACE
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
    "bouncing": "[@moreau1988; @wang1992]",
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
        "Models": " ".join(_models(config["fits"], facts["bounces"])),
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
    yield "Samples at the error level of a sensor, or out of its range, were excluded first."
    if rotation["mains_hz"]:
        yield (
            f"Sinusoids at the mains frequency ({rotation['mains_hz']:g} Hz) and its harmonics were fitted "
            "at rest, and subtracted where they exceed the noise."
        )
    yield (
        f"The reading at rest, found in windows of {rotation['window_s']:g} s, defines zero. No filter was "
        "applied."
    )
    if any(laser["beam"] for laser in config["lasers"].values()):
        yield (
            "Displacements were converted to rotations by the exact geometry of a rectangle that rotates "
            "about its lower corners. The centre of its base moves sideways by "
            f"{facts['shift_mm']} mm at most; in the models it does not. A sinking corner changes the "
            "reading, too: the modelled rotation is the one that the same beam would show of the modelled "
            "block."
        )


def _runs(processing: Mapping[str, Any]) -> Iterator[str]:
    runs, impacts = processing["runs"], processing["impacts"]
    yield (
        "A run begins at the release of a held block, and ends at rest. The release angle was read over the "
        f"last {runs['held_s']:g} s of the hold. The first {1000 * runs['finger_s']:g} ms after the release, "
        "in which the finger may still touch the block, were not fitted."
    )
    yield (
        f"A run with fewer than {runs['min_impacts']} impacts, or more than "
        f"{100 * runs['max_flagged_fraction']:g} % invalid samples, failed."
    )
    yield (
        "The restitution of an impact is the angular rate after it over the rate before it. It follows from "
        "the peaks before and after the impact by the exact motion of a rigid block [@housner1963]. Peaks "
        f"below {impacts['min_amplitude_sigmas']:g} standard deviations of the noise were not used. Modelled "
        "rotations were treated alike."
    )


def _models(fits: Mapping[str, Any], bounces: Sequence[str]) -> Iterator[str]:
    named = [f"{LAWS[model].label} {LAWS_CITED.get(model, '')}".rstrip() for model in fits["models"]]
    yield f"Laws fitted: {', '.join(named)}."
    if wider := [LAWS[model].label for model in fits["models"] if LAWS[model].cases]:
        were = "were" if len(wider) > 1 else "was"
        yield f"{' and '.join(wider)} {were} fitted only if the residuals of the others exceed the noise."
    for law in bounces:
        yield (
            f"{LAWS[law].label} {LAWS_CITED[law]} is a rigid block in the plane whose corners bounce with "
            "restitution e and slide with Coulomb friction μ; it was fitted to runs that bounced, from the "
            "rotation alone."
        )
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
            "Variants of these laws, in which the block rotates about the corner that stays down or the "
            "contact width is free, were tried if no candidate with fewer parameters explains the run."
        )


def _identification(fits: Mapping[str, Any], facts: Mapping[str, Any], free: Pairs) -> Iterator[str]:
    freed = "; ".join(f"{names}: {what}" for names, what in free)
    yield (
        "Each run was fitted by itself. The squared residual over the power of the noise, plus the squares "
        "of the shifts of the inputs over their standard uncertainties, was minimised by a trust region "
        "[@virtanen2020], from the best points of a scan, over growing parts of the run. If the residual "
        "exceeds the noise, the inputs were fixed as stated."
    )
    yield f"Free besides the parameters of the law: {freed}{' (paper mode)' if fits['paper_mode'] else ''}."
    yield "The discrepancy is ε_θ = ∫(θ_th − θ_ex)² dt / ∫θ_ex² dt up to the end of the run [@spanos2017]."
    if facts["n_integrated"]:
        low, high = facts["rtol_low"], facts["rtol_high"]
        yield (
            "The foundation's laws were integrated with a relative tolerance of "
            f"{low}{f' to {high}' if high != low else ''}, whose error shifts no parameter by more than "
            f"{facts['error_percent']} % of its standard error; Housner's is a closed form. The last step "
            "used every valid sample, averaged where that raises no standard error by more than 2 %."
        )


def _choice() -> str:
    return (
        "A candidate explains a run if four conditions hold. Its residual agrees with the noise at rest "
        "in every octave (spectra by sine tapers [@riedel1995], Fisher's F). The "
        "largest pull of an input (its shift over the standard deviation of that shift) has a p-value above "
        f"{REJECTS:.2g}. No parameter of a larger law is significant if added ({TRACE:.1f} standard errors). "
        "ε_θ is below 1 when it predicts the second half of the run from the first half, and the run, with "
        "refitted release, from other runs of its record. A candidate is rejected if its Bayesian "
        f"information criterion [@schwarz1978] is {TELLS:g} above that of another one; or if a larger "
        f"candidate, of which it is a special case, has a lower criterion and a −2 ln L lower by {TELLS:g}. "
        "Of the others, the one with the fewest free parameters is selected. If none explains a run, the "
        "nearest is selected and marked as such."
    )


def _uncertainty(config: Mapping[str, Any]) -> Iterator[str]:
    yield (
        "If the residual agrees with the noise at rest, standard errors follow from the spectrum of that "
        "noise. Otherwise they are at least those from the scatter and correlation of the residual."
    )
    if config["fits"]["profile"]:
        yield "Intervals are those of the profile likelihood."
    yield (
        "Runs of a record were combined by a random-effects model of ln k, ln c, ln λ and the logit of r, "
        "with its spread after [@paule1982] and its standard error after [@hartung2001]. The mean of a law "
        "uses only the runs that the law explains, if it explains any run of the record; otherwise all "
        "fitted runs. Total standard uncertainties add those of block, sensor and clock [@jcgm2008]."
    )
    scenes = {(line["foundation"], line["block"]) for line in config["records"]}
    if len(scenes) > len({foundation for foundation, _ in scenes}):
        yield (
            "To test whether blocks share the parameters of a foundation, the scatter between blocks was "
            "compared with the scatter between the runs of each block, for all parameters together and with "
            "a spread for each block [@coombs1996; @krishnamoorthy2004]. A second test, χ² of the means, "
            "includes the uncertainties of block, sensor and clock. Blocks differ if both p-values are below "
            "0.05."
        )


def _software(software: Mapping[str, str], git: str) -> str:
    versions = ", ".join(f"{name} {version}" for name, version in software.items())
    return f"{versions}, run by Snakemake [@molder2021]; state of the code: {git}."
