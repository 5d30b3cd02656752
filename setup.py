"""What pyproject.toml can't say: a wheel holds the workflow in freerock/snakemake, laid out as here."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

WORKFLOW = ("Snakefile", "workflow", "profiles")
LOCK = "requirements.lock"  # from which `freerock init` names tested versions


class WithWorkflow(build_py):
    """The package with the workflow beside it; an editable install finds the checkout's own."""

    def run(self) -> None:
        super().run()
        if self.editable_mode:
            return
        home = Path(self.build_lib, "freerock", "snakemake")
        shutil.rmtree(home, ignore_errors=True)
        home.mkdir(parents=True)
        for part in map(Path, (*WORKFLOW, LOCK)):
            if part.is_dir():
                shutil.copytree(part, home / part, ignore=shutil.ignore_patterns("__pycache__", ".*"))
            else:
                shutil.copyfile(part, home / part)


setup(cmdclass={"build_py": WithWorkflow})
