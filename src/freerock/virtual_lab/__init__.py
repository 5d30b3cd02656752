"""The virtual laboratory: simulated records of free-rocking tests, with their truth."""
