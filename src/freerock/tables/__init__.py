"""Tables of a campaign: tidy CSV, the numbers of the paper's tables, and these as printed text and LaTeX."""

__all__ = [
    "choices",
    "csvfile",
    "latex",
    "markdown",
    "number_text",
    "paper",
    "plan_text",
    "populations",
    "printed",
    "results",
    "swings",
    "tidy_tables",
]
