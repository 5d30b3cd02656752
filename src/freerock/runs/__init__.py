"""θ(t) to runs, and runs to impacts."""
