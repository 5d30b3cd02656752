"""The keys of `ground_motions`, with their defaults."""

from typing import Annotated, Literal

from freerock.config.values import Folder, OneOrMore, Positive, Section, Whole, key


class GroundMotionsSection(Section):
    """Ground motions under which the identified law of each record is simulated."""

    folder: Folder = key("the folder of the accelerograms, as .at2 or tables", min_length=1)
    scales: Annotated[tuple[Positive, ...], OneOrMore] = key("factors on each motion, one or more", (1.0,))
    draws: Whole = key("sets of parameters for each motion, including the means", 20, ge=1, le=10_000)
    of: Literal["next", "mean"] = key(
        "the parameters that are drawn: of the next run, or the mean ones", "next"
    )
    motions_per_job: Whole = key("the largest number of motions per job", 10, ge=1)
