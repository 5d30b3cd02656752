"""What each script of the workflow imports, and the processor time that this takes: the price of a job.

python -m freerock_bench.imports
"""

import ast
import subprocess
import sys

from freerock.jobs.home import HOME

HEAVY = ("scipy", "numba", "pandas", "xarray", "lmfit", "matplotlib", "jinja2", "bokeh")
REPORT = """
import sys, time
known = [name for name in {heavy} if name in sys.modules]
ours = sum(name.startswith("freerock") for name in sys.modules)
print("%6.2f s  %3d modules of freerock  %s" % (time.process_time(), ours, " ".join(known)))
"""


def imports_of(script: str) -> str:
    """The lines of a script that import modules, without its work."""
    lines = ast.parse(script).body
    return "\n".join(ast.unparse(line) for line in lines if isinstance(line, ast.Import | ast.ImportFrom))


def main() -> None:
    """Print a line for each script, the quickest of three processes."""
    for path in sorted((HOME / "workflow/scripts").glob("*.py")):
        program = imports_of(path.read_text(encoding="utf-8")) + REPORT.format(heavy=HEAVY)
        command = [sys.executable, "-c", program]
        told = [subprocess.run(command, capture_output=True, text=True, check=True).stdout for _ in range(3)]
        print(f"{path.stem:15}{min(told)}", end="")


if __name__ == "__main__":
    main()
