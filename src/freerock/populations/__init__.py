"""Runs and blocks together: means, predictions, uncertainty budget."""
