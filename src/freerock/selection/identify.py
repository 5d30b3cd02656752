"""All candidates fitted to the runs of a record, and the law that is chosen."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from freerock.errors import FreerockError
from freerock.identification.fit import Followers, settled
from freerock.identification.fitted import Fit
from freerock.identification.paper_fit import PaperFit, paper_fit
from freerock.identification.posed import Ended
from freerock.identification.significance_levels import REJECTS
from freerock.identification.start import Followed
from freerock.models.block import Block
from freerock.models.laws import CANDIDATES, PAPER_MODELS
from freerock.runs.motion import Motion
from freerock.selection.candidates import Allowed, n_numbers
from freerock.selection.choice import CHOICE, Choice, choose


@dataclass(frozen=True)
class SearchSettings:
    """How far candidates are followed; by judgement.

    Parameters
    ----------
    behind : float
        Times the least mean square of the first swings, from which a candidate's search ends after a few
        evaluations.
    hopeless : float
        -2 ln L there by which a candidate is worse than the best one, from which it is no contender. Where
        the best leaves more than the noise, in units of what it leaves.
    far : float
        Times the noise: where the best candidate leaves more, and runs scatter, no larger one is tried.
    """

    behind: float = 100.0
    hopeless: float = 30.0
    far: float = 10.0


SEARCH = SearchSettings()


@dataclass
class Identified:
    """What was found of the runs of a record.

    Parameters
    ----------
    fits : dict of str to dict of int to Fit
        By candidate and run.
    paper : dict of int to dict of str to PaperFit
        By run and law.
    missing : dict of str to str
        Why a candidate was not fitted.
    ruled_out : dict of str to str
        Why the first swings reject a law that is fitted nonetheless; see `choose`.
    """

    fits: dict[str, dict[int, Fit]] = field(default_factory=dict)
    paper: dict[int, dict[str, PaperFit]] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)
    ruled_out: dict[str, str] = field(default_factory=dict)

    @property
    def choice(self) -> Choice:
        """The law that the record needs."""
        return choose(self.fits, self.missing, self.ruled_out)


def identify_record(block: Block, motions: Mapping[int, Motion], allowed: Allowed) -> Identified:
    """Fit the candidates of a campaign to the runs of a record, few numbers first.

    Each is screened on the first swings of the first run. The laws of the campaign as the paper has them are
    always fitted. The search ends where a candidate leaves no more than the noise and no input is pulled.

    Parameters
    ----------
    block : Block
    motions : mapping of int to Motion
        Usable runs by number.
    allowed : Allowed
    """
    found = Identified()
    if not motions:
        return found
    least, followed = float("inf"), dict[str, Followed]()
    rank = {name: max(n_numbers(name), 2) for name in allowed.candidates}  # of one and of two together
    for n in sorted({*rank.values()}):
        own, left = dict[str, Followers](), dict[str, Ended]()
        for name in (each for each in rank if rank[each] == n):
            with _missed(name, found):
                own[name] = Followers(name, block, motions, allowed.settings(name), followed)
                left[name] = own[name].followed.glimpsed[0]
        followed |= {name: each.followed for name, each in own.items()}
        least = min([least, *(each.over_noise for each in left.values())])
        for name in sorted(left, key=lambda each: left[each].over_noise):
            if left[name].over_noise > SEARCH.behind * max(least, 1.0):
                break
            with _missed(name, found):
                left[name] = own[name].followed.screened[0]
                least = min(least, left[name].over_noise)
        _fit_tier(own, left, least, allowed, found)
        if _suffices(found) or _is_far(found):
            break
    for name in allowed.candidates:
        if name not in found.fits:
            found.missing.setdefault(name, "a smaller candidate suffices, or is as far from the runs")
    _as_the_paper(block, motions, allowed, found)
    return found


def _fit_tier(
    own: Mapping[str, Followers],
    screenings: Mapping[str, Ended],
    least: float,
    allowed: Allowed,
    found: Identified,
) -> None:
    """Fit contenders in full, and roughly what is always fitted and does not contend."""
    contend, ends = [name for name in screenings if _contends(screenings[name], least)], dict[str, Ended]()
    for name in contend:
        with _missed(name, found):
            ends[name] = own[name].end_of_first
    least_end = min((end.over_noise for end in ends.values()), default=float("inf"))
    for name in sorted(screenings, key=lambda each: screenings[each].over_noise):
        share, where = screenings[name].over_noise / least, "first swings"
        if name in ends:
            share, where = ends[name].over_noise / least_end, "whole first run"
        contends = name in ends and _contends(ends[name], least_end)
        if not contends:
            is_fitted = name in allowed.always
            told = found.ruled_out if is_fitted else found.missing
            told[name] = f"on the {where} it leaves {share:.3g} times the best's mean square"
            if not is_fitted:
                continue
        with _missed(name, found):
            found.fits[name] = settled(own[name].ends(not contends), not contends)


@contextmanager
def _missed(name: str, found: Identified) -> Iterator[None]:
    """Go on without a candidate whose fit fails, and keep why."""
    try:
        yield
    except (FreerockError, np.linalg.LinAlgError) as error:
        found.missing[name] = str(error)


def _contends(end: Ended, least: float) -> bool:
    return end.posed.samples.measured.size * (end.over_noise - least) <= SEARCH.hopeless * max(least, 1.0)


def _suffices(found: Identified) -> bool:
    """Whether a candidate leaves no more than the noise in all runs, and no input is pulled."""
    for own in (own for name, own in found.fits.items() if name not in found.ruled_out):
        agree = all(fit.success and fit.evidence.agrees for fit in own.values())
        if agree and all(fit.uncertainty.contributions.p_of_pulls > REJECTS for fit in own.values()):
            return True
    return False


def _is_far(found: Identified) -> bool:
    """Whether the best foundation's law leaves so much of runs that scatter that a larger one is no use.

    One that needs a larger scatter than blocks have is wrong: a larger law may need none.
    """
    fits = {
        max(fit.evidence.residual_over_noise for fit in own.values()): own
        for name, own in found.fits.items()
        if "k" in CANDIDATES[name].parameters and all(fit.success for fit in own.values())
    }
    if not fits or min(fits) <= SEARCH.far:
        return False
    sigma_r = next(iter(fits[min(fits)].values())).scatter.of_record.sigma_r
    return 0 < sigma_r <= CHOICE.scatters


def _as_the_paper(block: Block, motions: Mapping[int, Motion], allowed: Allowed, found: Identified) -> None:
    """The paper's fits; those of later runs start from that of the first and from their own fit."""
    rule, first = allowed.settings(allowed.candidates[0]).debonding, dict[str, PaperFit]()
    laws = [law for law in PAPER_MODELS if law in allowed.laws]
    for run, motion in motions.items():
        found.paper[run] = {}
        for law in laws:
            own, near = found.fits.get(law, {}).get(run), list[Mapping[str, float]]()
            near += [own.values] if own else []
            near += [first[law].values] if law in first else []
            try:
                found.paper[run][law] = paper_fit(law, block, motion, rule, near)
                first.setdefault(law, found.paper[run][law])
            except FreerockError as error:
                found.missing.setdefault(law, str(error))
