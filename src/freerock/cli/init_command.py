"""A working folder for an installed freerock: its few files, for version control.

example:
  freerock init my_laboratory

Writes Snakefile, profiles/default, config/, raw/, requirements.txt, .gitignore and README.md.
Existing files are kept; constraints.txt, config/README.md and the schemas are renewed.
"""

import re
from argparse import Namespace
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

from freerock.config.reference import files
from freerock.errors import FreerockError
from freerock.files import write_text
from freerock.jobs.home import HOME

NO_CAMPAIGN = "campaigns: []"  # in config.yaml, until `freerock new-campaign` names the first
FOLDER = Path(__file__).with_name("folder")  # the files, as they are written
WRITTEN = ("Snakefile", "config/config.yaml", ".gitignore", "README.md", "raw/README.md")


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("folder", metavar="FOLDER", nargs="?", default=".", help="by default the current folder")


def run(chosen: Namespace) -> None:
    """Write the files of a folder; print which were written, which kept, and what to do next."""
    written, kept = init(chosen.folder)
    print(f"written: {', '.join(written) or 'nothing'}")
    if kept:
        print(f"kept:    {', '.join(kept)}")
    at = "" if Path(chosen.folder) == Path(".") else f"cd {chosen.folder}; "
    print(f"next:    {at}freerock new-campaign NAME --from FOLDER")


def init(folder: str | Path = ".") -> tuple[list[str], list[str]]:
    """Write what a laboratory's folder needs besides records and campaigns.

    Returns
    -------
    written, kept : list of str
        Paths of the files, relative to the folder.

    Raises
    ------
    FreerockError
        The folder is a checkout of freerock itself, or can't be written to.
    """
    folder = Path(folder)
    if (folder / "src/freerock").exists():
        raise FreerockError(folder, "is a checkout of freerock itself", "run it in your own folder")
    generated = {f"config/{name}": text for name, text in files(_text("config/README.md")).items()}
    generated["constraints.txt"] = constraints((HOME / "requirements.lock").read_text(encoding="utf-8"))
    once = {name: _text(name) for name in WRITTEN} | {
        "profiles/default/config.yaml": (HOME / "profiles/default/config.yaml").read_text(encoding="utf-8"),
        "requirements.txt": _text("requirements.txt").format(version=version("freerock")),
    }
    kept = [name for name in once if (folder / name).exists()]
    written = {name: text for name, text in once.items() if name not in kept} | {
        name: text for name, text in generated.items() if _other(folder / name, text)
    }
    for name, text in written.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        write_text(folder / name, text)
    return [*written], kept


def constraints(lock: str) -> str:
    """The versions of a lock for pip's option `-c`: a line a library, without checksums."""
    head = "# Libraries with which this version of freerock was tested; renewed by `freerock init`.\n"
    return head + "\n".join(re.findall(r"^(\S+==.*?)[ \\]*$", lock, re.M)) + "\n"


def _text(name: str) -> str:
    """A file of `FOLDER`, in which none is hidden."""
    return (FOLDER / name.removeprefix(".")).read_text(encoding="utf-8")


def _other(path: Path, text: str) -> bool:
    return not path.is_file() or path.read_text(encoding="utf-8") != text
