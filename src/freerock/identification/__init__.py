"""Runs to parameters, and to the law they need."""
