"""What the steps of the workflow do, a module per step; the checksum of their code; their logs."""

__all__ = ["code_checksum", "descriptions", "home", "make_fits", "make_record", "make_tables"]
