"""Bounds of what readers of files take as possible, each with its unit at the end of its name."""

SAMPLE_UNITS = 1e100  # sample; loggers write up to 9.9e37 for an overload
SHORTEST_STEP_S = 1e-12  # shortest sampling interval
LONGEST_STEP_S = 1e12  # longest sampling interval
