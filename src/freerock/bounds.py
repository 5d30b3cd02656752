"""Bounds of all readers of files and requests, each with its unit at the end of its name.

`python -m freerock_bench.bounds docs/reliability.md` prints these lines as a table.
"""

SAMPLE_UNITS = 1e100  # sample; loggers write up to 9.9e37 for an overload
SHORTEST_STEP_S = 1e-12  # shortest sampling interval
LONGEST_STEP_S = 1e12  # longest sampling interval

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
