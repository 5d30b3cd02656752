"""Physics: blocks, laws of the foundation, their motion. Imports nothing of the pipeline."""
