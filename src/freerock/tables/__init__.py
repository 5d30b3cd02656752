"""Tables of a campaign: tidy CSV, the numbers of the paper's tables, and these as printed text and LaTeX."""

__all__ = [
    "candidates",
    "csvfile",
    "latex",
    "markdown",
    "number_text",
    "plan_text",
    "populations",
    "printed_tables",
    "restitution_comparison",
    "summary",
    "swings",
    "tidy_tables",
]
