"""The command `freerock`: `subcommands` lists them, and each is the module of its name."""

__all__ = ["check", "export", "subcommands"]
