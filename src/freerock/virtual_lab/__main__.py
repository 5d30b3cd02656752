"""Write a campaign of the virtual laboratory into its folder.

python -m freerock.virtual_lab raw/palermo_virtual
python -m freerock.virtual_lab raw/wooden_blocks
"""

import sys
from collections.abc import Sequence
from pathlib import Path

from freerock.errors import FreerockError, exit_code
from freerock.virtual_lab import palermo, workbook

CAMPAIGNS = {"palermo_virtual": palermo.write_campaign, "wooden_blocks": workbook.write_campaign}


def main(arguments: Sequence[str]) -> int:
    """Write the campaign that the folder on the command line is named after; returns the exit code."""

    def write() -> None:
        folder = Path(arguments[0]) if len(arguments) == 1 else Path()
        if folder.name not in CAMPAIGNS:
            what = f"no folder {' or '.join(CAMPAIGNS)} given"
            raise FreerockError("freerock.virtual_lab", what, "name one, as raw/palermo_virtual")
        CAMPAIGNS[folder.name](folder)

    return exit_code(write)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
