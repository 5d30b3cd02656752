"""The virtual laboratory: simulated records with known truth."""
