"""Responses of the identified laws of a campaign to ground motions, and the probability of overturning.

example:
  freerock respond palermo_virtual --motions accelerograms --scales 0.5,1,1.5,2 --draws 20

Takes the selected law and the parameters of each record from results/CAMPAIGN/tables. Motions are
PEER AT2 files, or tables with a column of time and one as acceleration [g]. Writes response.csv
(a row per record, motion, scale and draw) and fragility.csv.
"""

from argparse import ArgumentTypeError, Namespace
from collections.abc import Callable
from pathlib import Path

from freerock.config.campaign import load_campaign
from freerock.errors import FreerockError


def add_arguments(add: Callable[..., object]) -> None:
    """Add the arguments of the subcommand."""
    add("campaign", metavar="CAMPAIGN", help="an analysed campaign")
    add("--motions", metavar="FOLDER", required=True, help="the folder of the accelerograms")
    add("--scales", type=_factors, default=(1.0,), help="factors on each motion, as 0.5,1,2")
    add("--draws", type=int, default=20, help="sets of parameters, including the means")
    add("--of", choices=("next", "mean"), default="next", help="draw parameters of the next run, or the mean")
    add("--into", metavar="FOLDER", help="by default results/CAMPAIGN/response")


def run(chosen: Namespace) -> None:
    """Respond to ground motions."""
    campaign = load_campaign(Path("config/campaigns", f"{Path(chosen.campaign).stem}.yaml"))
    tables = Path("results", campaign.name, "tables")
    for name in ("choice", "populations"):
        if not (tables / f"{name}.csv").is_file():
            remedy = f"run snakemake --config campaigns={campaign.name} first"
            raise FreerockError(tables / f"{name}.csv", "is missing", remedy)

    from freerock.config.step_settings import geometries, scenes_tested
    from freerock.jobs.make_responses import fragility_table, known_laws, make_responses
    from freerock.response.motions import ground_motions_in
    from freerock.tables.csvfile import read_csv, write_csv

    motions, wrong = ground_motions_in(chosen.motions)
    for each in wrong:
        print(each)
    if wrong:
        raise FreerockError(chosen.motions, f"{len(wrong)} files are refused", "correct or remove them")
    choice, populations = (read_csv(tables / f"{name}.csv") for name in ("choice", "populations"))
    laws = known_laws(choice, populations, chosen.of)
    if not laws:
        what = "no record names a law that explains its runs"
        raise FreerockError(tables / "choice.csv", what, "name one by fits.models, or test again")
    blocks, into = geometries(campaign), Path(chosen.into or tables.parent / "response")
    debonding = campaign.fits.debonding
    responses = make_responses(laws, blocks, motions, chosen.scales, chosen.draws, debonding)
    curves = fragility_table(responses, scenes_tested(campaign))
    for name, table in (("response", responses), ("fragility", curves)):
        write_csv(table, into / f"{name}.csv")
    for (test, model), own in responses.groupby(["test", "model"], sort=False):
        share = own["overturned"].mean()
        print(f"{test} ({model}): overturns in {share:.1%} of {len(own)} responses, {campaign.origin} runs")
    for test in curves.loc[curves["kind"] == "no_law", "test"]:
        print(f"{test}: no law explains its runs, or no run is usable, so whether it overturns is not known")
    print(f"\nwritten: {into}/response.csv, fragility.csv")


def _factors(text: str) -> tuple[float, ...]:
    """Factors above 0, with commas."""
    try:
        factors = tuple(float(each) for each in text.split(","))
    except ValueError:
        factors = ()
    if not factors or min(factors) <= 0:
        raise ArgumentTypeError(f"{text!r} are no factors above 0, as 0.5,1,2")
    return factors
