"""Which hypothesis a run needs: candidates, their search, what each explains, and reasons to warn."""

__all__ = [
    "allowed_hypotheses",
    "choice",
    "hypotheses_tried",
    "reasons_after_fits",
]
