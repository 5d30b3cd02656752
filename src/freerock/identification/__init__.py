"""One candidate on the runs of a record: model of a run, start, least squares by lmfit, scatter of impacts.

A fit goes `settings` → `run_model` → `start` → `posed` (the least squares) → `scatter` → `goodness` →
`posterior` → `fit`, which gives `fitted.Fit`; `paper_fit` is the paper's own.
"""
