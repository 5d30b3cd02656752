"""What the jobs of the workflow do, one module per step; which code they run, their logs, what they leave."""

__all__ = [
    "batches",
    "code_identity",
    "fit",
    "home",
    "ledger",
    "metadata",
    "misfit",
    "record",
    "respond",
    "supplement",
    "whole_products",
]
