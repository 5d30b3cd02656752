"""What the jobs of the workflow do, one module per step; which code they run, their logs, what they leave."""

__all__ = [
    "batches",
    "code_identity",
    "home",
    "ledger",
    "make_fits",
    "make_record",
    "whole_or_rerun",
]
