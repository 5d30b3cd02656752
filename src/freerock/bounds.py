"""Bounds of all readers of files and requests, each with its unit at the end of its name.

`python -m freerock_bench.bounds docs/reliability.md` prints these lines as a table.
"""

# Memory: doubles of a coarse converter at rest shrink some 20 times, a constant 1000 times, of which
# LITTLE_BYTES holds half an hour at 10 kHz.
UNPACKED_TIMES = 100  # data of a record over the size of its file
LITTLE_BYTES = 1 << 27  # data of a record in any case
RECORD_CHANNELS = 2000  # record
SAMPLE_UNITS = 1e100  # sample; loggers write up to 9.9e37 for an overload
SHORTEST_STEP_S = 1e-12  # shortest sampling interval
LONGEST_STEP_S = 1e12  # longest sampling interval
HDF5_GROUPS = 50  # above an array of HDF5
HDF5_WALK_S = 4  # processor time to go through HDF5
HDF5_WALK_BYTES_PER_S = 20_000_000  # HDF5 that takes a second more
LVM_SEGMENTS = 5000  # LVM
SHEETS_TIMES = 110  # unpacked Excel over the size of its file: XML shrinks no further
SHEETS_CELLS = 1_000_000  # Excel, or its bytes where they are more
SHEETS_ELEMENTS = 100_000  # others of Excel
SHEET_ROWS = 1 << 20  # sheet
SHEET_CELLS = 1 << 25  # sheet as wide as its widest row

JSON_BYTES = 50_000_000  # JSON
TEXT_BYTES = 8_000_000  # CSV and other texts of the configuration
YAML_BYTES = 1_000_000  # YAML
YAML_LEVELS = 30  # YAML
YAML_NODES = 50_000  # keys and values of YAML, aliases followed
CELL_CHARACTERS = 10_000  # cell of a CSV
NAME_CHARACTERS = 100  # name: it becomes part of a file name, which has 255 at most
NUMBER_CHARACTERS = 40  # number
LEAST_SI = 1e-12  # least number but 0
MOST_SI = 1e15  # largest number, whose cube a double still holds
RUN_SAMPLES = 100_000_000  # run that is planned or simulated

REQUEST_BYTES = 1_000_000  # request to the desk
REQUEST_RECORDS = 10_000  # corrected by a request
CORRECTED_RUNS = 1000  # set by hand or left out, of a record
