"""The command `freerock`: `subcommands` lists them, and each is a module `NAME_command`."""
