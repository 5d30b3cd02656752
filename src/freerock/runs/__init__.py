"""Free-rocking runs in θ(t), the impacts in a run, and the input of a fit.

`runs.find_runs` finds the runs and judges them (`reasons_as_measured`), `impacts.find_impacts` the impacts
of one.
"""
