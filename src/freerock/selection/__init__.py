"""Which hypothesis a run needs: candidates, their search, what each explains, and doubts."""

__all__ = [
    "allowed_hypotheses",
    "choice",
    "doubts",
    "hypotheses_tried",
]
