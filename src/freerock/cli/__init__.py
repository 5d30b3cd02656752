"""The command `freerock`: one subcommand per task, one line per problem.

A subcommand is a function that adds its arguments to a parser and names the function that runs it; what that
needs is imported when it runs, so that `freerock --help` answers at once.
"""

import argparse
import sys
from collections.abc import Sequence
from contextlib import suppress

from freerock.errors import FreerockError

LOG = "freerock.log"
EXIT_CODES = """\
exit codes:
  0  done
  1  a file or value is refused; each problem is one line: where: what; what to do
  2  the command line is not understood
  3  an error of freerock itself
The last failure's traceback is in freerock.log of the current folder; --debug shows it as well.
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
        return _failed(error, str(error), 1, chosen)
    except BrokenPipeError:  # the reader, such as head, has seen enough
        sys.stdout = None
    except Exception as error:
        what = f"{type(error).__name__}: {error}".partition("\n")[0]
        return _failed(error, f"freerock {chosen.command}: {what}; report it with {LOG}", 3, chosen)
    return 0


def _failed(error: Exception, line: str, code: int, chosen: argparse.Namespace) -> int:
    """Tell an error in a line, and its traceback to the log."""
    import traceback

    trace = "".join(traceback.format_exception(error))
    with suppress(OSError), open(LOG, "w", encoding="utf-8") as log:
        log.write(f"freerock {chosen.command}\n{line}\n\n{trace}")
    print(f"{trace}{line}" if chosen.debug else line, file=sys.stderr)
    return code


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="freerock",
        description="Free-rocking tests, from laser volts to identified models.",
        epilog=f"example:\n  freerock inspect raw/palermo_virtual/config2_marble.tdms\n\n{EXIT_CODES}",
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


def _inspect_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = (
        "example:\n"
        "  freerock inspect raw/palermo_virtual/config2_marble.tdms\n"
        "\n"
        "Formats: docs/records.md. The record file is only read."
    )
    parser.add_argument("file", metavar="FILE", help="a record file")
    parser.add_argument("--no-plot", action="store_true", help="print only")
    parser.add_argument("--into", metavar="FOLDER", default="results/inspect", help="where the picture goes")
    parser.set_defaults(run=_inspect)


def _inspect(chosen: argparse.Namespace) -> None:
    from pathlib import Path

    from freerock.cli.inspect import look_into, look_text, quick_look, save_picture

    look = look_into(chosen.file)
    print(look_text(look))
    if not chosen.no_plot:
        picture = Path(chosen.into) / f"{look.path.name}.png"
        save_picture(quick_look([look]), picture)
        print(f"\nwritten: {picture}")


def _new_campaign_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = (
        "example:\n"
        "  freerock new-campaign marble_2026 --from /media/usb/marble\n"
        "\n"
        "Copies the records to raw/NAME, lists their checksums, and writes config/campaigns/NAME.yaml and\n"
        "NAME.csv, where what only you know is marked FILL_IN. Nothing that exists is overwritten."
    )
    parser.add_argument("name", metavar="NAME", help="name of the campaign: letters, digits and _")
    parser.add_argument(
        "--from", dest="folder", metavar="FOLDER", required=True, help="folder of the record files"
    )
    parser.set_defaults(run=_new_campaign)


def _new_campaign(chosen: argparse.Namespace) -> None:
    from freerock.cli.inspect import look_text
    from freerock.cli.new_campaign import new_campaign
    from freerock.config.mistakes import FILL_IN

    made = new_campaign(chosen.name, chosen.folder)
    print("\n\n".join(map(look_text, made.looks)))
    for error in made.refused:
        print(f"left out: {error}", file=sys.stderr)
    print(f"\nwritten: {made.raw}, {made.csv}, {made.yaml}, {made.picture}")
    print(f"next:    replace each {FILL_IN} in {made.yaml} and {made.csv}")
    print(f"         freerock check {chosen.name}")
    print(f"         snakemake --config campaigns={chosen.name}")
    print("To analyse it with every `snakemake`, add its name to campaigns in config/config.yaml.")


def _check_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = (
        "example:\n"
        "  freerock check palermo_virtual\n"
        "\n"
        "Tells every mistake of the configuration at once, and whether record files, channels, units,\n"
        "calibrations and checksums are as it says. Nothing is computed or written."
    )
    parser.add_argument(
        "campaign",
        metavar="CAMPAIGN",
        nargs="?",
        help="its name or YAML file; left out, the campaigns of config/config.yaml",
    )
    parser.set_defaults(run=_check)


def _check(chosen: argparse.Namespace) -> None:
    from freerock.cli.check import check_config
    from freerock.config.mistakes import ConfigError

    sound, problems = check_config(campaign=chosen.campaign)
    for line in sound:
        print(f"{line}: nothing to correct")
    if problems:
        raise ConfigError(problems)


def _plan_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = (
        "example:\n"
        "  freerock plan palermo_virtual\n"
        "\n"
        "The campaign's section `plan` says what is expected and what may be chosen: see config/README.md."
    )
    parser.add_argument(
        "campaign", metavar="CAMPAIGN", help="its name or YAML file, with its CSV file beside"
    )
    parser.add_argument(
        "--into",
        metavar="FOLDER",
        help="where plan.csv, plan.pdf and plan.png go; left out, results/<campaign>/plan",
    )
    parser.set_defaults(run=_plan)


def _plan(chosen: argparse.Namespace) -> None:
    from pathlib import Path

    from freerock.config.campaign import load_campaign

    named = chosen.campaign.endswith((".yaml", ".yml"))
    path = Path(chosen.campaign) if named else Path("config/campaigns") / f"{chosen.campaign}.yaml"
    campaign = load_campaign(path)  # refused before the numerical libraries are loaded

    from freerock.config import steps as settings
    from freerock.figures.plan import draw
    from freerock.figures.style import save
    from freerock.identification.plan import plan_campaign, plan_text

    frame = plan_campaign(campaign)
    labels = settings.labels(campaign)
    folder = Path(chosen.into or f"results/{campaign.name}/plan")
    pages, drawn = draw(frame, labels)
    save(pages, drawn, folder / "plan")
    print(plan_text(frame, labels))
    print(f"\nwritten: {folder / 'plan'}.csv, .pdf, .png")


def _simulate_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = (
        "example:\n"
        "  freerock simulate examples/shake_table.yaml\n"
        "  freerock simulate examples/virtual_record.yaml\n"
        "\n"
        "A scene with a laser becomes a record file (TDMS), as the virtual laboratory records it; any other\n"
        "becomes θ(t) of each model (CSV, PDF, PNG), on a moving ground or a resting one."
    )
    parser.add_argument("scene", metavar="SCENE.yaml", help="the scene, see config/README.md")
    parser.add_argument("--into", metavar="FOLDER", default="results/simulate", help="where the files go")
    parser.set_defaults(run=_simulate)


def _simulate(chosen: argparse.Namespace) -> None:
    from pathlib import Path

    from freerock.config import scene as scenes

    path = Path(chosen.scene)
    scene = scenes.load_scene(path)
    stem = Path(chosen.into) / path.stem
    if scene.laser:
        scenes.write_scene_record(scene, stem.with_suffix(".tdms"))
        print(f"written: {stem}.tdms (simulated)")
        return

    from freerock.figures.style import save

    frame, responses = scenes.simulate_scene(scene, path.parent)
    save(scenes.scene_figure(frame), frame, stem, origin="simulated")
    print(scenes.scene_text(scene, responses))
    print(f"\nwritten: {stem}.csv, .pdf, .png (simulated)")


def _compare_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = (
        "example:\n  freerock compare results/palermo_virtual results/palermo_again --csv changes.csv"
    )
    parser.add_argument("a", metavar="A", help="results of a campaign, as results/palermo_virtual")
    parser.add_argument("b", metavar="B", help="results to compare with them")
    parser.add_argument("--csv", metavar="FILE", help="write every parameter of either to a table")
    parser.set_defaults(run=_compare)


def _compare(chosen: argparse.Namespace) -> None:
    from freerock.cli.compare import compare_results, comparison_text
    from freerock.tables.csvfile import write_csv

    found = compare_results(chosen.a, chosen.b)
    print(comparison_text(found, chosen.a, chosen.b))
    if chosen.csv:
        write_csv(found.parameters, chosen.csv)


def _progress_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = (
        "example:\n  freerock progress palermo_virtual\n\nRun it beside snakemake, in another terminal."
    )
    parser.add_argument("campaign", metavar="CAMPAIGN", nargs="*", help="left out, those of config.yaml")
    parser.set_defaults(run=_progress)


def _progress(chosen: argparse.Namespace) -> None:
    import time

    from freerock.cli.progress import newest_run, progress, progress_text
    from freerock.config.campaign import load_config

    started = newest_run()
    for name, campaign in load_config(campaigns=chosen.campaign or None).campaigns.items():
        tests = [record.test for record in campaign.records]
        print(progress_text(name, progress(f"results/{name}", tests, started, time.time())))


COMMANDS = {
    "inspect": ("show what is in a record file", _inspect_arguments),
    "new-campaign": ("begin a campaign from a folder of record files", _new_campaign_arguments),
    "check": ("check configuration and files in seconds, without running anything", _check_arguments),
    "plan": ("predict, before any test, how well each parameter will be known", _plan_arguments),
    "simulate": (
        "simulate a scene: a virtual record, or θ(t) of models on a shake table",
        _simulate_arguments,
    ),
    "progress": ("tell how far snakemake is, what has failed, and when it will be done", _progress_arguments),
    "compare": ("tell what changed between two analyses of a campaign", _compare_arguments),
}
