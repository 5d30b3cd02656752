"""Write the virtual Palermo campaign into its folder.

python -m freerock.virtual_lab raw/palermo_virtual
"""

import sys
from collections.abc import Sequence
from pathlib import Path

from freerock.errors import FreerockError, exit_code
from freerock.virtual_lab.palermo import palermo_records
from freerock.virtual_lab.write_tdms import write_records


def main(arguments: Sequence[str]) -> int:
    """Write the campaign into the folder on the command line; returns the exit code."""

    def write() -> None:
        if [Path(each).name for each in arguments] != ["palermo_virtual"]:
            what = "no folder palermo_virtual given"
            raise FreerockError("freerock.virtual_lab", what, "name one, as raw/palermo_virtual")
        write_records(arguments[0], palermo_records())

    return exit_code(write)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
