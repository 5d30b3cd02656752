"""The virtual laboratory: simulated records of free-rocking tests, with their truth."""

__all__ = ["added_noise", "palermo", "published", "virtual_record", "write_tdms"]
