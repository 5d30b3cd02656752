"""Golden solutions: scenes of rocking solved to twelve digits twice, and the score of anybody's solution."""

__all__ = [
    "dop853",
    "files",
    "fixed_point",
    "grade",
    "make",
    "motion",
    "ours",
    "scenes",
    "score",
    "table",
    "taylor",
]
