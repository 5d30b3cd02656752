"""What a job takes before its work: processor time of its imports, and the packages that it imports.

python benchmarks/startup.py [record fit quality …]
"""

import ast
import subprocess
import sys
from pathlib import Path

SCRIPTS = Path(__file__).parents[1] / "workflow/scripts"
REPEATS = 5
PACKAGES = ["numpy", "scipy", "pandas", "xarray", "netCDF4", "lmfit", "numba", "matplotlib", "pydantic"]
ENDS = f"""
import sys, time
print(time.process_time(), *(each for each in {PACKAGES} if each in sys.modules))
"""


def started(name: str) -> tuple[float, list[str]]:
    """Least processor time [s] of an interpreter that imports what a script does, and packages of note.

    Snakemake's own module comes first, by which it hands a script its inputs.
    """
    statements = ast.parse((SCRIPTS / f"{name}.py").read_text(encoding="utf-8")).body
    imports = [ast.unparse(each) for each in statements if isinstance(each, ast.Import | ast.ImportFrom)]
    interpreter = [
        sys.executable,
        "-c",
        "\n".join(["from snakemake.script import Snakemake", *imports, ENDS]),
    ]
    told = [
        subprocess.run(interpreter, check=True, capture_output=True, text=True).stdout.split()
        for _ in range(REPEATS)
    ]
    return min(float(each[0]) for each in told), told[0][1:]


if __name__ == "__main__":
    for script in sys.argv[1:] or sorted(path.stem for path in SCRIPTS.glob("*.py")):
        seconds, packages = started(script)
        print(f"{script:16s} {seconds:.2f} s of processor time: {', '.join(packages)}")
