"""Bounds of what readers of files take as possible, each with its unit at the end of its name."""

SHORTEST_STEP_S = 1e-12  # shortest sampling interval
LONGEST_STEP_S = 1e12  # longest sampling interval
