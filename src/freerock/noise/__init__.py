"""The noise of a signal: where it stands still, σ of a sample, the mains and other lines, the spectrum.

`still_signal` knows σ of a sample of a channel. `sensor_noise` finds the noise of a record, `spectrum.Noise`,
at rest and where it is louder while the block swings.
"""
