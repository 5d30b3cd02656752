"""What an error of the law adds to the uncertainty of restitution by energy.

A law that leaves more than the noise has energies of swings wrong. Two traces of it are seen. The
duration of a swing over that of the law at the same height tells by what share a couple is wrong. A δ
that alternates, more so the lower the swing, tells that swings have another zero than the block at rest:
a bed is softer on one side, or a base slips.
"""

from collections.abc import Mapping

import numpy as np

from freerock.arrays import Floats
from freerock.config.processing import ImpactLimits
from freerock.identification.fitted import Fit
from freerock.models.block import Block
from freerock.populations.impact_energy import ImpactEnergy, impact_energy
from freerock.rotation.view import view_of
from freerock.runs.impacts import Impacts, find_impacts
from freerock.runs.motion import Motion

NEAR = 2  # swings to either side, over which the share of a swing is averaged
HIGHEST = 0.99  # of the critical angle: no swing lasts for ever


def energies_of_record(
    fits: Mapping[int, Mapping[str, Fit]],
    motions: Mapping[int, Motion],
    block: Block,
    limits: ImpactLimits,
    debonding: str,
) -> dict[int, dict[str, ImpactEnergy]]:
    """Restitution by energy at the impacts of each fit that is to be used, by run and candidate.

    Parameters
    ----------
    fits : mapping of int to mapping of str to Fit
        By run of a record and candidate, with the impacts of the modelled motion.
    motions : mapping of int to Motion
        As seen, by run.
    block : Block
    limits : ImpactLimits
        Of the impacts that are seen.
    debonding : str
        The rule of the fits.
    """
    found = dict[int, dict[str, ImpactEnergy]]({number: {} for number in fits})
    seen = {
        number: find_impacts(
            each.time_s, each.theta, each.sigma_theta, block, theta0=each.theta0, limits=limits
        )
        for number, each in motions.items()
    }
    for name in {name: None for own in fits.values() for name in own}:
        own = {number: of_run[name] for number, of_run in fits.items() if name in of_run}
        plain = {
            number: _at_its_inputs(fit, motions[number], debonding)
            for number, fit in own.items()
            if fit.success and fit.impacts is not None and motions[number].laboratory is not None
        }
        for number, each in with_law_error(plain, own, seen, block).items():
            found[number][name] = each
    return found


def _at_its_inputs(fit: Fit, motion: Motion, debonding: str) -> ImpactEnergy:
    """The energies at the impacts of a fit, with the inputs where it has moved them."""
    known, at, view = fit.uncertainty.contributions, motion.laboratory, motion.view
    assert at is not None and fit.impacts is not None
    if known.moved.any():
        at = at.at(known.inputs, known.moved)
        view = view_of([*at.lasers.values()], at.block)
    return impact_energy(fit, at.block, fit.impacts.time_s, debonding=debonding, view=view, laboratory=at)


def with_law_error(
    energies: Mapping[int, ImpactEnergy],
    fits: Mapping[int, Fit],
    measured: Mapping[int, Impacts],
    block: Block,
) -> dict[int, ImpactEnergy]:
    """Restitution by energy whose u holds the error of the law, where a fit leaves more than the noise.

    Parameters
    ----------
    energies : mapping of int to ImpactEnergy
        Of one candidate by run of a record, at the impacts of the modelled motion.
    fits : mapping of int to Fit
        With the impacts of the modelled motion.
    measured : mapping of int to Impacts
        As seen.
    block : Block
    """
    wrong = [run for run in energies if not fits[run].evidence.agrees and fits[run].impacts is not None]
    found = dict(energies)
    if not wrong:
        return found
    shares = {run: _shares(fits[run], measured[run], block) for run in wrong}
    seen = np.concatenate([*shares.values()])
    usual = float(np.sqrt(np.mean(seen**2))) if seen.size else 0.0
    zero = _zero([fits[run] for run in wrong], block)
    for run in wrong:
        r = energies[run].restitution
        after = np.full(r.size, usual)
        known = min(r.size, shares[run].size)
        after[:known] = shares[run][:known]
        before = np.append(after[:1], after[:-1])
        by_zero = zero * _per_zero(fits[run], block)[: r.size]
        of_law = r * np.sqrt((before**2 + after**2) / 4 + by_zero**2)
        found[run] = energies[run]._replace(u_total=np.hypot(energies[run].u_total, of_law))
    return found


def _shares(fit: Fit, measured: Impacts, block: Block) -> Floats:
    """Share of its energy that each swing between two impacts has more or less than the law has it.

    Root mean squares over neighbours, shape (n_swings,). A swing of a rigid block that rises to θ lasts as
    acosh(1/(1 - θ/θ_cr)) (Housner 1963, equation 8); a couple that is larger by a share a makes it shorter by
    a/2.
    """
    assert fit.impacts is not None
    n = min(len(measured.time_s), len(fit.impacts.time_s))
    if n < 2:
        return np.zeros(0)
    lasts, seen = (np.diff(each.time_s[:n]) for each in (fit.impacts, measured))
    tops, seen_tops = (_duration(each.peak_after_rad[: n - 1], block) for each in (fit.impacts, measured))
    square = (2 * np.log(seen / lasts * tops / seen_tops)) ** 2
    near = [np.nanmean(square[max(i - NEAR, 0) : i + NEAR + 1]) for i in range(n - 1)]
    return np.asarray(np.sqrt(np.nan_to_num(near)))


def _duration(tops: Floats, block: Block) -> Floats:
    """Duration of rigid swings to some heights, over a constant."""
    return np.asarray(np.arccosh(1 / (1 - np.minimum(np.abs(tops) / block.theta_cr, HIGHEST))))


def _per_zero(fit: Fit, block: Block) -> Floats:
    """What a zero that is off adds to ln r of each impact [rad⁻¹], shape (n_impacts,).

    Half the relative slopes of the energy at the top before and at that after it: they lie on two sides.
    """
    assert fit.impacts is not None
    tops = np.abs(np.append(fit.values.get("theta0", fit.curve.theta_model[0]), fit.impacts.peak_after_rad))
    tops = np.minimum(tops, HIGHEST * block.theta_cr)
    slopes = np.sin(block.theta_cr - tops) / (2 * np.sin(tops / 2) * np.sin(block.theta_cr - tops / 2))
    return np.asarray((slopes[:-1] + slopes[1:]) / 2)


def _zero(fits: list[Fit], block: Block) -> float:
    """By how much swings of a record may have another zero than the block at rest [rad].

    Of a least squares of δ: a constant of each run, a slope over the logarithm of the height, and the zero.
    Root of the squares of its value and its standard uncertainty; 0 where too few impacts are free.
    """
    rows, delta, weight = [], [], []
    for j, fit in enumerate(fits):
        assert fit.impacts is not None
        n = min(fit.scatter.delta.size, fit.impacts.peak_after_rad.size)
        tops, own = fit.impacts.peak_after_rad[:n], np.zeros((n, len(fits)))
        own[:, j] = 1.0
        rows.append(np.column_stack([own, np.log(np.abs(tops)), np.sign(tops) * _per_zero(fit, block)[:n]]))
        delta.append(fit.scatter.delta[:n])
        weight.append(1 / np.hypot(fit.scatter.u_delta[:n], fit.scatter.of_record.sigma_r))
    design, seen, by = np.vstack(rows), np.concatenate(delta), np.concatenate(weight)
    sound = np.isfinite(design).all(axis=1) & np.isfinite(by)
    design, seen = design[sound] * by[sound, None], (seen * by)[sound]
    if len(seen) <= design.shape[1]:
        return 0.0
    found, *_ = np.linalg.lstsq(design, seen, rcond=None)
    variance = np.linalg.pinv(design.T @ design)[-1, -1]
    scatter = float(np.sum((seen - design @ found) ** 2)) / (len(seen) - design.shape[1])
    return float(np.sqrt(found[-1] ** 2 + variance * min(scatter, 1.0)))
