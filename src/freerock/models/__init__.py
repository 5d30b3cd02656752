"""Physics: blocks, the ground, laws of the foundation, their motion. Imports nothing of the pipeline.

A law is a row in `laws` with its numbers in `free_parameters`, and formulas in `kernel`; some have a Taylor
series of free rocking in `series`. `simulate` is the way in.
"""
