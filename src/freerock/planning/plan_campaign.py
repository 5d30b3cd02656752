"""The plan of a campaign: setups of its records, choices of its section `plan`."""

from collections.abc import Sequence
from typing import NamedTuple

import pandas as pd

from freerock.config.campaign import Campaign
from freerock.config.step_settings import laboratory
from freerock.errors import FreerockError
from freerock.planning.plan import Choices, Setup, plan, plan_rivals
from freerock.planning.plan_total import plan_budget, plan_known, plan_totals
from freerock.rotation.laboratory import Laboratory


class Plan(NamedTuple):
    """What a campaign will know, as from `plan`, `plan_rivals`, `plan_budget` and `plan_totals`."""

    errors: pd.DataFrame
    rivals: pd.DataFrame
    budget: pd.DataFrame
    totals: pd.DataFrame


def plan_campaign(campaign: Campaign) -> Plan:
    """The plan of a campaign as loaded: the setups are those of its records, which need not exist yet.

    A restitution per impact is planned as one r, that of `plan.expected`.

    Raises
    ------
    FreerockError
        The campaign has no section `plan`, or one of its sensors has no scale.
    """
    section, fits = campaign.plan, campaign.fits
    if section is None:
        remedy = "write what is expected of each foundation, and the sensors (config/README.md)"
        raise FreerockError(f"campaign {campaign.name}: plan", "is missing", remedy)
    nominal = {name: block.release_angle_deg for name, block in campaign.blocks.items()}
    angles: dict[str, Sequence[float]] = {name: (angle,) for name, angle in nominal.items() if angle}
    angles |= section.release_angles_deg
    setups = [
        Setup(
            (each.block, each.foundation, laser),
            Laboratory.of(laboratory(campaign, each.model_copy(update={"laser": laser}))),
            section.expected[each.foundation],
            angles[each.block],
        )
        for each in campaign.records
        for laser in each.lasers
    ]
    choices = Choices(
        section.sensors,
        section.sampling_rates_hz,
        section.durations_s,
        campaign.processing.runs.finger_s,
        section.model_error,
        fits.models,
        fits.kinematics,
        {law: [name for name in names if name != "r_per_impact"] for law, names in fits.freed.items()},
        fits.debonding,
    )
    errors, known = plan(setups, choices), plan_known(setups, choices)
    totals = plan_totals(errors, known, section.n_runs, section.spread_fraction)
    return Plan(errors, plan_rivals(setups, choices), plan_budget(known), totals)
