"""The noise of a signal: where it stands still, σ of a sample, the mains and other lines, the spectrum.

`still_phases` finds where a signal stands still, and `signal_noise` σ of a sample of a channel there.
`rotation_noise` finds the noise of θ of a record, a `spectrum.Noise`, at rest and in motion.
"""
