"""A working folder for an installed freerock: its few files, for version control."""

import re
from argparse import ArgumentParser, Namespace
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from freerock.config.reference import files
from freerock.errors import FreerockError
from freerock.files import write_text
from freerock.jobs.home import HOME

NO_CAMPAIGN = "campaigns: []"  # in config.yaml, until `freerock new-campaign` names the first
WRITTEN = {
    "Snakefile": """\
# `snakemake` analyses the campaigns of config/config.yaml by the workflow of the installed freerock.
from freerock.jobs.home import SNAKEFILE


module freerock:
    snakefile:
        SNAKEFILE
    config:
        config


use rule * from freerock
""",
    "config/config.yaml": f"""\
# yaml-language-server: $schema=config.schema.json
# The campaigns to analyse: each has its <name>.yaml and <name>.csv in config/campaigns.
{NO_CAMPAIGN}
""",
    ".gitignore": ".snakemake/\n.venv/\nexports/\nresults/\nfreerock.log\n*_supplement.zip\n",
    "README.md": """\
# Free-rocking tests

Records and settings of free-rocking tests, analysed by freerock.

Once on each computer, in this folder:

```sh
python3 -m venv .venv
. .venv/bin/activate
pip install -r requirements.txt   # this version of freerock; its wheel may stand in this folder
```

For each campaign:

```sh
freerock new-campaign NAME --from FOLDER   # copies records to raw/NAME, begins the configuration
freerock check NAME                        # lists what to fill in, with file, line and remedy
snakemake                                  # analyses the campaigns of config/config.yaml
freerock verify                            # compares all products with what a run would make
```

Before `snakemake`, edit `config/campaigns/NAME.yaml` and `config/campaigns/NAME.csv` until
`freerock check NAME` finds nothing to correct. `config/README.md` explains the keys. The first analysis
compiles code, which takes about half a minute. Later ones compute only what changed.

The report is `results/NAME/report.html`. `freerock run NAME` does the same as `snakemake`, with a progress
bar. `freerock review NAME` shows the runs and takes corrections. `freerock supplement NAME` packs a campaign
for a paper; it requires `creator` and `license` in `NAME.yaml`. `freerock --help` lists all commands.

Keep this folder under version control. `.gitignore` excludes what is made from the rest, such as `results/`.

`constraints.txt` pins the libraries with which this version of freerock was tested. Other versions can
change last digits. A newer freerock: install it, and write its version into `requirements.txt`.
`freerock init` then renews `constraints.txt`, `config/README.md` and the schemas. `freerock check` names
each key whose name has changed.
""",
    "raw/README.md": """\
A folder for each campaign: its record files and their checksums, `manifest.csv`. Nothing writes to them.
""",
}
REQUIREMENTS = """\
freerock=={version}
-c constraints.txt
-f .  # a wheel of freerock in this folder
"""
INTRODUCTION = """\
# Configuration

`config/config.yaml` names the campaigns to analyse. A campaign is

- `config/campaigns/NAME.yaml`: blocks, foundations, lasers, and settings where they differ from the defaults;
- `config/campaigns/NAME.csv`: one line per record file;
- `raw/NAME/`: the record files, and `manifest.csv` with their checksums.

`freerock new-campaign NAME --from FOLDER` begins all three and marks with `FILL_IN` what only you know.
`freerock add NAME FILE…` adds records, `freerock check NAME` shows what is missing or wrong.

Lengths are in metres, masses in kilograms, times in seconds. Angles are in degrees where the key ends in
`_deg`. Only the keys marked compulsory must be given. The files `*.schema.json` let editors check the keys.

In the CSV, `exclude`: `2;3` leaves out runs 2 and 3, `record` the whole record; they stay in the tables,
marked. `override`: `2@12.310:19.800` sets the release of run 2 to 12.310 s and its end to 19.800 s, in the
time of the record. `reason` is compulsory with either.

"""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the subcommand."""
    parser.epilog = (
        "example:\n"
        "  freerock init my_laboratory\n"
        "\n"
        "Writes Snakefile, profiles/default, config/, raw/, requirements.txt, .gitignore and README.md.\n"
        "Existing files are kept; constraints.txt, config/README.md and the schemas are renewed."
    )
    parser.add_argument(
        "folder", metavar="FOLDER", nargs="?", default=".", help="by default the current folder"
    )


def run(chosen: Namespace) -> None:
    """Write the files of a folder; print which were written, which kept, and what to do next."""
    made = init(chosen.folder)
    print(f"written: {', '.join(made.written) or 'nothing'}")
    if made.kept:
        print(f"kept:    {', '.join(made.kept)}")
    at = "" if Path(chosen.folder) == Path(".") else f"cd {chosen.folder}; "
    print(f"next:    {at}freerock new-campaign NAME --from FOLDER")


@dataclass(frozen=True)
class Made:
    """Paths of the files written and kept, relative to the folder."""

    written: tuple[str, ...]
    kept: tuple[str, ...]


def init(folder: str | Path = ".") -> Made:
    """Write what a laboratory's folder needs besides records and campaigns.

    Raises
    ------
    FreerockError
        The folder is a checkout of freerock itself, or can't be written to.
    """
    folder = Path(folder)
    if (folder / "src/freerock").exists():
        raise FreerockError(folder, "is a checkout of freerock itself", "run it in your own folder")
    generated = {f"config/{name}": text for name, text in files(INTRODUCTION).items()}
    generated["constraints.txt"] = constraints((HOME / "requirements.lock").read_text(encoding="utf-8"))
    once = WRITTEN | {
        "profiles/default/config.yaml": (HOME / "profiles/default/config.yaml").read_text(encoding="utf-8"),
        "requirements.txt": REQUIREMENTS.format(version=version("freerock")),
    }
    kept = tuple(name for name in once if (folder / name).exists())
    written = {name: text for name, text in once.items() if name not in kept} | {
        name: text for name, text in generated.items() if _other(folder / name, text)
    }
    for name, text in written.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        write_text(folder / name, text)
    return Made(tuple(written), kept)


def constraints(lock: str) -> str:
    """The versions of a lock for pip's option `-c`: a line a library, without checksums."""
    head = "# Libraries with which this version of freerock was tested; renewed by `freerock init`.\n"
    return head + "\n".join(re.findall(r"^(\S+==.*?)[ \\]*$", lock, re.M)) + "\n"


def _other(path: Path, text: str) -> bool:
    return not path.is_file() or path.read_text(encoding="utf-8") != text
