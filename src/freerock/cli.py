"""The command `freerock`: one subcommand per task, one line per problem.

A subcommand is a function that adds its arguments to a parser and names the function that runs it; what that
needs is imported when it runs, so that `freerock --help` answers at once.
"""

import argparse
import sys
import traceback
from collections.abc import Sequence

from freerock.errors import FreerockError

EXIT_CODES = """\
exit codes:
  0  done
  1  a file or value is refused; each problem is one line: where: what; what to do
  2  the command line is not understood
  3  an error of freerock itself; --debug shows where
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
    chosen = _parser().parse_args(arguments)
    try:
        chosen.run(chosen)
        sys.stdout.flush()
    except FreerockError as error:
        return _failed(error, str(error), 1, chosen.debug)
    except BrokenPipeError:  # the reader, such as head, has seen enough
        sys.stdout = None
    except Exception as error:
        what = f"{type(error).__name__}: {error}".partition("\n")[0]
        return _failed(error, f"freerock {chosen.command}: {what}; report it with --debug", 3, chosen.debug)
    return 0


def _failed(error: Exception, line: str, code: int, debug: bool) -> int:
    if debug:
        traceback.print_exception(error)
    print(line, file=sys.stderr)
    return code


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="freerock",
        description="Free-rocking tests, from laser volts to identified models.",
        epilog=EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(dest="command", required=True, title="commands", metavar="COMMAND")
    for name, (summary, add_arguments) in COMMANDS.items():
        command = commands.add_parser(
            name,
            help=summary,
            description=f"{summary[0].upper()}{summary[1:]}.",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        add_arguments(command)
        command.epilog = f"{command.epilog}\n\n{EXIT_CODES}"
        command.add_argument("--debug", action="store_true", help="show where in freerock an error arose")
    return parser


def _plan_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = (
        "example:\n"
        "  freerock plan config/campaigns/palermo_virtual.yaml\n"
        "\n"
        "The campaign's section `plan` says what is expected and what may be chosen: see config/README.md."
    )
    parser.add_argument("campaign", metavar="CAMPAIGN.yaml", help="the campaign, with its CSV file beside it")
    parser.add_argument(
        "--into",
        metavar="FOLDER",
        help="where plan.csv, plan.pdf and plan.png go; left out, results/<campaign>/plan",
    )
    parser.set_defaults(run=_plan)


def _plan(chosen: argparse.Namespace) -> None:
    from pathlib import Path

    from freerock.config import load_campaign

    campaign = load_campaign(chosen.campaign)  # refused before the numerical libraries are loaded

    from freerock.figures import plan as figures
    from freerock.figures.style import save
    from freerock.plan import plan_campaign, plan_text

    frame = plan_campaign(campaign)
    labels = {name: each.label for name, each in {**campaign.blocks, **campaign.foundations}.items()}
    folder = Path(chosen.into or f"results/{campaign.name}/plan")
    folder.mkdir(parents=True, exist_ok=True)
    save(*figures.plan(frame, labels), folder / "plan")
    print(plan_text(frame, labels))
    print(f"\nwritten: {folder / 'plan'}.csv, .pdf, .png")


COMMANDS = {
    "plan": ("predict, before any test, how well each parameter will be known", _plan_arguments),
}

if __name__ == "__main__":
    sys.exit(main())
