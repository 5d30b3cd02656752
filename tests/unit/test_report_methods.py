"""The methods of a campaign: its real settings, and every citation with its entry."""

import re

import pytest
from fabricated import campaign
from reported import make, settings

from freerock.identification.significance_levels import REJECTS
from freerock.report.methods import REFERENCES

ENTRY = re.compile(r"@(?:article|book)\{(\w+),\n(?:  \w+ = \{.+\},\n)+\}\n")


@pytest.fixture
def written(tmp_path):
    """The methods and references of a made-up campaign with some settings."""

    def texts(datasets=None, **changes):
        make(tmp_path, datasets or campaign(), **changes)
        return [(tmp_path / f"methods.{suffix}").read_text(encoding="utf-8") for suffix in ("md", "bib")]

    return texts


def test_what_is_cited_has_its_entry_and_no_more(written):
    text, bib = written()
    body = text.rpartition("\n\n")[0]
    cited = set(re.findall(r"@(\w+)", body))
    assert cited == set(ENTRY.findall(bib)) == set(re.findall(r"^- @(\w+): doi:10\.", text, re.M))
    assert {"housner1963", "koh1986", "hunt1975", "spanos2017", "paule1982", "hartung2001"} <= cited


def test_every_reference_is_an_entry_with_a_doi():
    for key, known in REFERENCES.items():
        entry = known.entry
        assert ENTRY.fullmatch(entry), key
        assert entry.count("{") == entry.count("}")
        assert re.fullmatch(r"10\.\d{4,9}/\S+", known.doi)
        (year,) = re.findall(r"year = \{(\d{4})\}", entry)
        assert key.endswith(year) and year in known.short


def test_methods_tell_the_settings_of_the_campaign(written):
    text, _ = written()
    assert "**Tests.** 9 simulated runs in 5 records: Slender and Squat on Marble and Soft mat" in text
    assert "The first 30 ms after the release" in text
    assert "or below 2 times the amplitude from which the base lifts off" in text
    assert "Gravity: 9.81 m/s²." in text
    assert "no other: 0.3 mm (lengths of a block), 0.1 % (mass), 0.5 % (inertia), 0.6 mm (beam)" in text
    assert (
        "Laws fitted: Housner [@housner1963], Winkler [@koh1986], Hunt–Crossley [@hunt1975; @spanos2017]. "
        "General and Hardening would have been fitted where the residuals of the others exceed the noise. "
        in text
    )
    assert "Free besides the parameters of the law: Housner, Winkler, Hunt–Crossley: θ₀ and t₀." in text
    assert "a spread for each block" in text and "profile likelihood" not in text
    shipped = settings([])
    runs = shipped["processing"]["runs"] | {"finger_s": 0.05, "min_impacts": 5}
    changed = {
        "processing": shipped["processing"] | {"runs": runs},
        "fits": shipped["fits"] | {"models": ["housner"], "kinematics": [], "profile": True},
    }
    other, bib = written(**changed)
    assert "The first 50 ms after the release" in other
    assert "fewer than 5 impacts" in other
    assert "Laws fitted: Housner [@housner1963]." in other
    assert "profile likelihood" in other
    assert "Rivals of these laws" not in other
    assert "koh1986" not in other + bib


def test_methods_tell_the_objective_the_conditions_and_the_runs_of_a_mean(written):
    text = " ".join(written()[0].split())
    conditions = text.partition("if four conditions hold. ")[2].partition(" A candidate is rejected")[0]
    heads = ("Its residual agrees", "The largest pull of an input", "No parameter of a", "is below 1 when")
    places = [conditions.index(head) for head in heads]
    assert places == sorted(places) and f"{REJECTS:.2g}" in conditions
    assert "plus the squares of the shifts of the inputs" in text
    assert "the inputs were fixed as stated" in text
    assert "The mean of a law uses only the runs that the law explains" in text
