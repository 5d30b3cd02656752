"""The command `freerock`: one subcommand per task, one line per problem.

A subcommand is a line in `COMMANDS` and the module `NAME_command`, with `add_arguments(add)` and
`run(chosen)`. From "example:" on, the module's docstring is what the help says below the arguments. Only the
module that is requested is imported, so that `freerock --help` answers at once.
"""

import argparse
import importlib
import io
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib.metadata import version

from freerock.errors import FreerockError

COMMANDS = {  # what each does, as `freerock --help` lists it
    "init": "create a working folder for an installed freerock",
    "inspect": "show what is in a record file",
    "new-campaign": "begin a campaign from a folder of record files",
    "add": "add record files to a campaign",
    "check": "check configuration and files within seconds",
    "plan": "predict how well one run will tell each parameter, before any test",
    "review": "show, correct and refit runs in the browser",
    "verify": "compare products and record files with their checksums",
    "compare": "show what changed between two analyses of a campaign",
}
LOG = "freerock.log"
EXIT_CODES = """\
exit codes:
  0  done
  1  a file or value is refused; each problem is one line: where: what; remedy
  2  the command line is not understood
  3  an error of freerock itself
freerock.log in the current folder holds the last traceback; --debug also prints it.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand.

    Parameters
    ----------
    arguments : sequence of str, optional
        Of the command line, by default this process's.

    Returns
    -------
    int
        The exit code, see `EXIT_CODES`.
    """
    if isinstance(sys.stdout, io.TextIOWrapper):  # a locale without θ
        sys.stdout.reconfigure(errors="backslashreplace")
    words = sys.argv[1:] if arguments is None else [*arguments]
    chosen = argparse.Namespace(command=" ".join(words[:1]), debug="--debug" in words)
    try:
        chosen = _parser(*words[:1]).parse_args(words)  # imports the subcommand
        chosen.run(chosen)
        sys.stdout.flush()
    except FreerockError as error:
        return _failed(error, str(error), 1, chosen)
    except BrokenPipeError:  # the reader, such as head, has seen enough
        sys.stdout = None
    except Exception as error:
        what = f"{type(error).__name__}: {error}".partition("\n")[0]
        return _failed(error, f"freerock {chosen.command}: {what}; report it with {LOG}", 3, chosen)
    return 0


def _failed(error: Exception, line: str, code: int, chosen: argparse.Namespace) -> int:
    """Print an error as a line, and write its traceback to the log."""
    import traceback

    trace = "".join(traceback.format_exception(error))
    with suppress(OSError), open(LOG, "w", encoding="utf-8") as log:
        log.write(f"freerock {chosen.command}\n{line}\n\n{trace}")
    print(f"{trace}{line}" if chosen.debug else line, file=sys.stderr)
    return code


def _parser(asked_for: str = "") -> argparse.ArgumentParser:
    """The parser of the command line, with the arguments of the one subcommand that is requested."""
    parser = argparse.ArgumentParser(
        prog="freerock",
        description="Free-rocking tests, from laser volts to identified models.",
        epilog=f"example:\n  freerock inspect raw/palermo_virtual/config2_marble.tdms\n\n{EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    known = f"freerock {version('freerock')}"
    parser.add_argument("--version", action="version", version=known, help="show the version")
    commands = parser.add_subparsers(dest="command", required=True, title="commands", metavar="COMMAND")
    for name, summary in COMMANDS.items():
        command = commands.add_parser(
            name,
            help=summary,
            description=f"{summary[0].upper()}{summary[1:]}.",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if name == asked_for:
            module = importlib.import_module(f"freerock.cli.{name.replace('-', '_')}_command")
            module.add_arguments(command.add_argument)
            command.set_defaults(run=module.run)
            _, example, told = str(module.__doc__).partition("example:")
            command.epilog = f"{example}{told.rstrip()}\n\n{EXIT_CODES}"
            command.add_argument("--debug", action="store_true", help="show the traceback of an error")
    return parser
