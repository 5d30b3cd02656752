"""The scenes of the benchmark: solutions/README.md states them so that anybody can solve them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

from freerock.models.block import Block
from freerock.models.laws import DEBONDING, KINEMATICS
from freerock.virtual_lab.published import BLOCKS, RELEASE_ANGLES, TABLE_2

SAMPLE_S = 0.01  # between the instants quoted
SPAN_S = 3.0  # the last instant at most
PULSE_START_S, PULSE_END_S = 0.1, 0.3
PULSE_PERIOD_S = 0.2
DROPPED, DROP_M = "config2", 0.005
PULSES = {  # peaks of ẍ_g and z̈_g [m/s²]
    "config1": (3.6, 2.0),
    "config2": (4.4, 2.0),
    "config3": (5.4, -2.0),
}


@dataclass(frozen=True)
class Scene:
    """A block, what it stands on, and how it is set in motion.

    Parameters
    ----------
    name : str
        block_foundation_law_debonding_kinematics_excitation; Housner's block has no rule of debonding.
    law : str
        "housner", "winkler" or "hunt_crossley".
    block : Block
    parameters : mapping of str to float
        r [1]; k [N/m²] and c [N·s/m²] or λ [N·s/m³].
    debonding, kinematics : str
        As in `freerock.models.laws.Rules`.
    theta0 : float
        Angle at which it is released at rest [rad]; 0 where the ground shakes it.
    pulse : (float, float)
        Amplitudes of ẍ_g and z̈_g [m/s²], one cycle of a sine; 0 of a free motion.
    drop_m : float
        Height of the lower edge over the ground at the release [m]; 0 where the bed carries the block.
    """

    name: str
    law: str
    block: Block
    parameters: Mapping[str, float]
    debonding: str
    kinematics: str
    theta0: float
    pulse: tuple[float, float]
    drop_m: float = 0.0

    @property
    def breaks(self) -> tuple[float, ...]:
        """Instants at which the ground begins and ceases to move [s]."""
        return (PULSE_START_S, PULSE_END_S) if any(self.pulse) else ()


def scenes(size: str = "full") -> dict[str, Scene]:
    """Every scene by its name.

    Parameters
    ----------
    size : str
        "full", or "small": one scene of each law, rule, kinematics and excitation.
    """
    rules = {
        "housner": [("", "pivoting")],
        "winkler": [*product(DEBONDING, KINEMATICS)],
        "hunt_crossley": [*product(DEBONDING, KINEMATICS)],
    }
    places = [*product(BLOCKS, TABLE_2)] if size == "full" else [("config2", "marble")]
    every = [
        _scene(block, foundation, law, *rule, excitation)
        for block, foundation in places
        for law in rules
        for rule in rules[law]
        for excitation in ("free", "shaken", "dropped")
        if excitation != "dropped" or (block == DROPPED and law != "housner")
    ]
    return {scene.name: scene for scene in every}


def _scene(block: str, foundation: str, law: str, debonding: str, kinematics: str, excitation: str) -> Scene:
    shape, shaken = BLOCKS[block], excitation == "shaken"
    parts = (block, foundation, law, debonding, kinematics, excitation)
    return Scene(
        "_".join(part for part in parts if part),
        law,
        shape,
        TABLE_2[foundation][law],
        debonding or "geometric",
        kinematics,
        0.0 if shaken else RELEASE_ANGLES[block],
        PULSES[block] if shaken else (0.0, 0.0),
        DROP_M if excitation == "dropped" else 0.0,
    )


def instants(until_s: float = SPAN_S) -> list[float]:
    """The instants quoted, from 0 on [s]."""
    return [round(i * SAMPLE_S, 6) for i in range(math.floor(until_s / SAMPLE_S + 1e-9) + 1)]
