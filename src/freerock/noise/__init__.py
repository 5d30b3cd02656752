"""The noise of a signal: where it stands still, σ of a sample, the mains and other lines, the spectrum.

`at_rest.at_rest` finds the noise of a record, `spectrum.Noise`; `in_motion` where it is louder while the
block swings, `sums` what it does to sums.
"""
