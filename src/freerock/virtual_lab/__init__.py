"""The virtual laboratory: simulated records of free-rocking tests, with their truth."""

__all__ = ["faults", "noise", "palermo", "published", "record", "scene", "tdms", "truth", "workbook"]
