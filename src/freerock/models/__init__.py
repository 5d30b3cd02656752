"""Physics: blocks, the ground, laws of the foundation, their motion. Imports nothing of the pipeline.

A law is a row in `laws`, plain formulas in `contact` and compiled ones in `kernel` and, as
Taylor series of free rocking, in `series`; `simulate` is the way in.
"""
