"""Bounds of all readers of files and requests, each with its unit at the end of its name.

`python -m freerock_bench.bounds docs/reliability.md` prints these lines as a table.
"""

# Memory: doubles of a coarse converter at rest shrink some 20 times, a constant 1000 times, of which
# LITTLE_BYTES holds half an hour at 10 kHz.
UNPACKED_TIMES = 100  # data of a record, relative to the size of its file
LITTLE_BYTES = 1 << 27  # data of a record of a file below 1.34 MB
RECORD_CHANNELS = 2000  # record
SAMPLE_UNITS = 1e100  # sample; loggers write up to 9.9e37 for an overload
SHORTEST_STEP_S = 1e-12  # shortest sampling interval
LONGEST_STEP_S = 1e12  # longest sampling interval
HDF5_GROUPS = 50  # nesting of an HDF5 array
HDF5_WALK_S = 4  # processor time to list the contents of an HDF5 file
HDF5_WALK_BYTES_PER_S = 20_000_000  # size of that file per additional second
LVM_SEGMENTS = 5000  # LVM file
SHEETS_TIMES = 110  # unpacked Excel, relative to the size of its file: XML shrinks no further
SHEETS_CELLS = 1_000_000  # Excel file of at most 1 MB (larger ones may have one cell per byte)
SHEETS_ELEMENTS = 100_000  # Excel file, besides cells
SHEET_ROWS = 1 << 20  # sheet
SHEET_CELLS = 1 << 25  # sheet, with every row as wide as its widest

JSON_BYTES = 50_000_000  # JSON file
TEXT_BYTES = 8_000_000  # CSV and other texts of the configuration
YAML_BYTES = 1_000_000  # YAML file
YAML_LEVELS = 30  # nesting of YAML
YAML_NODES = 50_000  # keys and values of YAML, with aliases expanded
CELL_CHARACTERS = 10_000  # cell of a CSV
NAME_CHARACTERS = 100  # name: it becomes part of a file name, which has 255 at most
NUMBER_CHARACTERS = 40  # number
LEAST_SI = 1e-12  # smallest number except 0
MOST_SI = 1e15  # largest number: a double still holds its cube
RUN_SAMPLES = 100_000_000  # run that is planned or simulated

REQUEST_BYTES = 1_000_000  # request to the server of the review
REQUEST_RECORDS = 10_000  # corrected by one request
CORRECTED_RUNS = 1000  # set by hand, or excluded, in a record
