"""The noise of a signal: where it stands still, σ of a sample, the mains and other lines, the spectrum.

`still_phases` finds the phases of stillness, `signal_noise` σ of a sample of a channel in them.
`rotation_noise` finds the noise of θ of a record, a `spectrum.Noise`, at rest and where it is louder while
the block swings.
"""
