"""Volts of a record to θ(t) with its uncertainty, flags and faults.

`rotation.find_rotation` does it all; the other modules hold what it is made of and what others use besides:
sensors and the geometry of their beams, flags of samples, faults of a signal.
"""
