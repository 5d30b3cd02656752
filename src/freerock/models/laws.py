"""The rocking models: a law is one row; the candidates of a fit follow from the laws.

Whatever lists models (configuration, fits, tables, figures, report) reads these rows. Unit, bounds and grid
of a number stand in `free_parameters`.
What a law of the foundation does is written in `kernel`: a new one needs its terms in `_pressure` (force),
`_force_factors` (force and moment over the base) and `stored` (energy). `series` has the same as sums, for
speed, of laws with `by_series`. A rigid block is written in `housner`. The configuration reads the rows too,
so nothing is imported here that is slow to load.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from freerock.models.block import Block
from freerock.models.free_parameters import COMMON_NUISANCES, PARAMETERS, PER_RUN

DEBONDING = ("geometric", "tensionless")
KINEMATICS = ("guided", "pivoting")


@dataclass(frozen=True)
class Rules:
    """What a model assumes besides its law.

    Parameters
    ----------
    debonding : str
        "geometric" (contact where the base is below the ground, z > 0) or "tensionless" (contact where z > 0
        and the foundation pushes, f > 0).
    kinematics : str
        "guided" (the base centre moves up and down only, as in the paper) or "pivoting" (the block turns
        about the corner that stays down). Housner's block pivots under either.
    """

    debonding: str = "geometric"
    kinematics: str = "guided"


GEOMETRIC = Rules()


class Foundation(NamedTuple):
    """Coefficients of the contact law, per unit width of the base.

    One law f(z, ż) = k z + c ż + λ z ż acts wherever base and foundation are in contact (Spanos et al. 2017,
    section 3, doi:10.1016/j.proeng.2017.09.024): λ = 0 is the Winkler model, c = 0 the Hunt-Crossley model.

    Parameters
    ----------
    k : float
        Stiffness [N/m²].
    c : float
        Linear damping [N·s/m²].
    lam : float
        Hunt-Crossley damping λ [N·s/m³].
    """

    k: float
    c: float = 0.0
    lam: float = 0.0

    @classmethod
    def of(cls, parameters: Mapping[str, float]) -> "Foundation":
        """The foundation that a model's parameters, named as in `laws`, describe; those it lacks are zero."""
        return cls(parameters["k"], parameters.get("c", 0.0), parameters.get("lambda", 0.0))

    @property
    def is_damped(self) -> bool:
        """Whether it takes energy from the block."""
        return self.c > 0 or self.lam > 0

    def constants(self, block: Block, pivots: bool = False) -> tuple[float, ...]:
        """The law and the block as `kernel.integrate` takes them."""
        m = block.mass_kg
        law = (self.k / m, self.c / m, self.lam / m, block.flat, block.h, block.inertia_base / m, block.g)
        return (*law, block.flat if pivots else 0.0, block.edge_radius_m, block.e)


@dataclass(frozen=True)
class Law:
    """A rocking model.

    Parameters
    ----------
    label : str
        Its name in tables and figures.
    parameters : tuple of str
        Keys of `PARAMETERS`; of a law of the foundation the stiffness k comes first.
    may_free : tuple of str
        What a fit may free besides.
    free : tuple of str
        What a fit frees of these by default.
    published : bool
        Whether Spanos et al. 2017 (doi:10.1016/j.proeng.2017.09.024) identified it.
    cases : tuple of str
        Laws that it becomes when one of its numbers is zero. It is fitted only where they leave more than
        noise, and starts where they end on the first swings. A law with several dampings needs them.
    tensionless : bool
        Whether the tensionless rule of debonding is implemented where none of its ratios is zero.
    kinematics : tuple of str
        What its base may do sideways, the paper's first (`Rules`).
    by_series : bool
        Whether `series` knows its force, k z + c ż + λ z ż; else `kernel` integrates it alone.
    cites : str
        Its sources, as the methods of a report cite them (`report.methods`).
    note : str
        What it is, as the reference of the configuration and the report say it.
    """

    label: str
    parameters: tuple[str, ...]
    may_free: tuple[str, ...] = COMMON_NUISANCES
    free: tuple[str, ...] = PER_RUN
    published: bool = False
    cases: tuple[str, ...] = ()
    tensionless: bool = True
    kinematics: tuple[str, ...] = KINEMATICS
    by_series: bool = False
    cites: str = ""
    note: str = ""

    @property
    def is_foundation(self) -> bool:
        """Whether the block stands on a compliant foundation; else both are rigid."""
        return "k" in self.parameters

    @property
    def ratios(self) -> tuple[str, ...]:
        """The parameters beside k of a foundation, found as ratios to it; each may be zero."""
        return tuple(name for name in self.parameters if PARAMETERS[name].fitted_as == "ratio")

    def allows(self, debonding: str, n_ratios: int) -> bool:
        """Whether a rule of debonding is implemented where as many of `ratios` are not zero."""
        return self.tensionless or debonding != "tensionless" or n_ratios < len(self.ratios)


LAWS = {
    "housner": Law(
        "Housner",
        ("r",),
        ("width", "tilt", *PER_RUN),
        published=True,
        kinematics=("pivoting",),
        cites="[@housner1963]",
        note="a rigid block on rigid ground that loses speed at each impact",
    ),
    "winkler": Law(
        "Winkler",
        ("k", "c"),
        published=True,
        by_series=True,
        cites="[@koh1986]",
        note="a bed of springs and dashpots",
    ),
    "hunt_crossley": Law(
        "Hunt–Crossley",
        ("k", "lambda"),
        published=True,
        by_series=True,
        cites="[@hunt1975; @spanos2017]",
        note="springs with a damping that grows with depth",
    ),
    # f = k z + c ż + λ z ż
    "general": Law(
        "General",
        ("k", "c", "lambda"),
        cases=("winkler", "hunt_crossley"),
        tensionless=False,
        by_series=True,
        note="both dampings, c and λ",
    ),
}


@dataclass(frozen=True)
class Candidate:
    """What is fitted to a run: a law with its kinematics, with or without the contact width freed.

    Parameters
    ----------
    law : str
        A key of `LAWS`.
    kinematics : str
        One of those of the law.
    width : bool
        Whether the contact width is freed.
    """

    law: str
    kinematics: str
    width: bool = False

    @property
    def name(self) -> str:
        """The law's name alone is the paper's model; what differs from it follows."""
        return self._joined(self.law, "_", "pivoting", "width")

    @property
    def label(self) -> str:
        """Its name in tables and figures."""
        return self._joined(LAWS[self.law].label, ", ", "pivoting", "width free")

    @property
    def cases(self) -> tuple[str, ...]:
        """Candidates of the cases of its law, with the same kinematics and width."""
        return tuple(Candidate(law, self.kinematics, self.width).name for law in LAWS[self.law].cases)

    @property
    def is_rival(self) -> bool:
        """Whether it differs from the paper's law."""
        return self.width or self.kinematics != LAWS[self.law].kinematics[0]

    @property
    def parameters(self) -> tuple[str, ...]:
        """The parameters of its law, and the width where it is freed."""
        return (*LAWS[self.law].parameters, *(("width",) if self.width else ()))

    def _joined(self, law: str, comma: str, pivoting: str, width: str) -> str:
        named = [pivoting] if self.kinematics != LAWS[self.law].kinematics[0] else []
        return comma.join([law, *named, *([width] if self.width else [])])


def _candidates() -> dict[str, Candidate]:
    """Every law with each of its kinematics and with the width or without, by how many numbers they add."""
    every = [
        Candidate(name, kinematics, width)
        for width in (False, True)
        for rank in range(len(KINEMATICS))
        for name, law in LAWS.items()
        for kinematics in law.kinematics[rank : rank + 1]
        if "width" in law.may_free or not width
    ]
    ordered = sorted(every, key=lambda each: len(LAWS[each.law].parameters) + each.width)
    return {each.name: each for each in ordered}


CANDIDATES = _candidates()
MODELS = {model: LAWS[each.law].parameters for model, each in CANDIDATES.items()}
MODEL_LABELS = {model: each.label for model, each in CANDIDATES.items()}
PAPER_MODELS = tuple(model for model, law in LAWS.items() if law.published)


def law_of(model: str) -> Law:
    """The law of a candidate."""
    return LAWS[CANDIDATES[model].law]


def alike(model: str, law: str) -> str:
    """The candidate of another law that is like one in kinematics and width."""
    return replace(CANDIDATES[model], law=law).name
