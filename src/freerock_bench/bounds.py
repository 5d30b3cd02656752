"""The table of bounds in docs/reliability.md, from freerock.bounds.

python -m freerock_bench.bounds docs/reliability.md
"""

import re
import sys
from pathlib import Path

from freerock import bounds
from freerock_bench.document import in_markdown, renew

LINE = re.compile(r"^([A-Z0-9_]+) = .*?  # ([^;:\n]+)", re.M)
UNIT = re.compile(r"(BYTES_PER_S|[A-Z]+)$")
PLAIN = {"S": "s", "SI": "in SI units", "UNITS": "in any unit", "BYTES_PER_S": "bytes per second"}


def markdown() -> str:
    """A row for each bound: of what, and how much."""
    source = Path(str(bounds.__file__)).read_text(encoding="utf-8")
    return in_markdown(["quantity", "at most"], [(what, _size(name)) for name, what in LINE.findall(source)])


def _size(name: str) -> str:
    """A bound with its unit."""
    value, unit = getattr(bounds, name), UNIT.findall(name)[0]
    number = f"{value:,}".replace(",", " ") if isinstance(value, int) else f"{value:g}"
    return f"{number} {PLAIN.get(unit, unit.lower())}"


if __name__ == "__main__":
    renew(sys.argv[1], "bounds", markdown())
