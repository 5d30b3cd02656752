"""Which hypothesis a run needs: candidates, their search, what each explains, and doubts."""

__all__ = [
    "choice",
    "doubts",
    "hypotheses",
    "hypothesis_search",
]
