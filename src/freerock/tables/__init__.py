"""Tables of a campaign: tidy CSV, the numbers of the paper's tables, and these as printed text and LaTeX."""

__all__ = [
    "candidates",
    "csvfile",
    "latex",
    "markdown",
    "plan_text",
    "populations",
    "printed_tables",
    "quantities",
    "restitution_comparison",
    "restitution_law",
    "summary",
    "swings",
    "tidy",
]
