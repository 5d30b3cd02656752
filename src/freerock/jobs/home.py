"""Where the workflow lies: in the installed package, as setup.py packs it, or in the checkout around it."""

from pathlib import Path

PACKAGE = Path(__file__).parents[1]
PACKED = PACKAGE / "snakemake"  # of a wheel; no checkout has this folder
HOME = PACKED if PACKED.is_dir() else PACKAGE.parents[1]  # holds Snakefile, workflow and profiles
SNAKEFILE = HOME / "Snakefile"
SCRIPTS = HOME / "workflow" / "scripts"
