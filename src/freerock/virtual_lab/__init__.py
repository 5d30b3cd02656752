"""The virtual laboratory: simulated records of free-rocking tests, with their truth."""

__all__ = ["faults", "noise", "palermo", "record", "scene", "tdms", "truth", "workbook"]
