"""Volts of a record to θ(t) with its uncertainty, flags and faults."""
