"""Write the virtual Palermo campaign into its folder.

python -m freerock.virtual_lab raw/palermo_virtual
"""

import sys

from freerock.virtual_lab.palermo import palermo_records
from freerock.virtual_lab.write_tdms import write_records

if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("python -m freerock.virtual_lab FOLDER: name the folder, as raw/palermo_virtual")
    write_records(sys.argv[1], palermo_records())
