"""What a person corrects in the runs of a record."""

from collections.abc import Sequence
from dataclasses import dataclass

from freerock.errors import FreerockError


@dataclass(frozen=True)
class ByHand:
    """Corrections by hand; they take precedence over what is found.

    Parameters
    ----------
    overrides : sequence of (run, release_s, end_s, reason)
        Release and end of a run [s].
    exclusions : sequence of (run, reason)
        Runs left out: kept in the list and marked.
    """

    overrides: Sequence[tuple[int, float, float, str]] = ()
    exclusions: Sequence[tuple[int, str]] = ()

    def override_of(self, number: int) -> tuple[float, float, str] | None:
        """Release and end of a run [s] and the reason, None where nobody set them."""
        found = {number: (release_s, end_s, reason) for number, release_s, end_s, reason in self.overrides}
        return found.get(number)

    def exclusion_of(self, number: int) -> str | None:
        """Why a run is left out, None where it is not."""
        return dict(self.exclusions).get(number)

    def refuse_unknown(self, n_runs: int) -> None:
        """Refuse to override or exclude runs that are not there."""
        named = {
            "override": {number for number, *_ in self.overrides},
            "exclude": {number for number, _ in self.exclusions},
        }
        for key, numbers in named.items():
            unknown = sorted(numbers - set(range(1, n_runs + 1)))
            if unknown:
                raise FreerockError(
                    key,
                    f"there is no run {', '.join(map(str, unknown))}",
                    "name run 1, the only one" if n_runs == 1 else f"name one of runs 1 to {n_runs}",
                )


NOTHING = ByHand()
