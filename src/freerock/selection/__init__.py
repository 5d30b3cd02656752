"""Which law the runs of a record need: candidates, their fits, the choice among them, and reasons to warn."""
