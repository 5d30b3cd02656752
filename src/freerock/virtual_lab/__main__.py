"""Write the virtual Palermo campaign into its folder.

python -m freerock.virtual_lab raw/palermo_virtual
"""

import sys
from collections.abc import Sequence
from pathlib import Path

from freerock.errors import FreerockError, exit_code
from freerock.virtual_lab.palermo import write_campaign


def main(arguments: Sequence[str]) -> int:
    """Write the campaign into the folder on the command line; returns the exit code."""

    def write() -> None:
        if [Path(each).name for each in arguments] != ["palermo_virtual"]:
            what = "no folder palermo_virtual given"
            raise FreerockError("freerock.virtual_lab", what, "name one, as raw/palermo_virtual")
        write_campaign(arguments[0])

    return exit_code(write)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
