"""`python -m freerock.cli` is the command `freerock`."""

import sys

from freerock.cli.subcommands import main

if __name__ == "__main__":
    sys.exit(main())
