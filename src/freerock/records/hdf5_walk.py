"""Go through an HDF5 file as a reader would, in a process of its own: damaged files end the library's.

python hdf5_walk.py FILE SECONDS MOST_BYTES    (a script that needs no other module of the package, and starts
fast)
"""

import resource
import sys
from math import prod

import h5py

ROW_BYTES = 1 << 22  # read at a time


def walk(path: str, most_bytes: float) -> None:
    """Read every attribute, and every dataset of numbers up to a size."""
    with h5py.File(path, locking=False) as file:
        dict(file.attrs)
        file.visititems(lambda _, item: _look(item, most_bytes))


def _look(item: h5py.HLObject, most_bytes: float) -> None:
    """Read the attributes of a group or dataset, and the dataset's own numbers."""
    dict(item.attrs)
    if not is_array(item) or 8 * prod(item.shape) > most_bytes:
        return
    rows = max(1, ROW_BYTES // (8 * max(1, prod(item.shape[1:]))))
    if item.shape:
        for first in range(0, item.shape[0], rows):
            item[first : first + rows]
    else:
        item[()]


def is_array(item: h5py.HLObject) -> bool:
    """Whether a group or dataset is an array of real numbers, all of it in the file."""
    if not isinstance(item, h5py.Dataset) or item.shape is None or item.dtype.kind not in "iuf":
        return False
    return not (item.is_virtual or item.external)


def limit_time(seconds: int) -> None:
    """End this process after so much processor time."""
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


if __name__ == "__main__":
    limit_time(int(sys.argv[2]))
    walk(sys.argv[1], float(sys.argv[3]))
