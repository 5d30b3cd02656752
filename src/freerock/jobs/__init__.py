"""What the jobs of the workflow do, one module per step; which code they run, their logs, what they leave."""

__all__ = [
    "batches",
    "fit",
    "home",
    "ledger",
    "metadata",
    "misfit",
    "record",
    "reruns",
    "respond",
    "supplement",
    "whole_products",
]
