"""The virtual laboratory: simulated records of free-rocking tests, with their truth."""

__all__ = ["noise", "palermo", "record", "scene", "tdms", "truth"]
