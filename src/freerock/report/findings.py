"""What a campaign found, in a few lines: sentences from its tables, every number of which stands in them."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import pandas as pd

from freerock.models.free_parameters import OF_RECORD, SYMBOLS
from freerock.models.laws import CANDIDATES, MODEL_LABELS, PAPER_MODELS, law_of
from freerock.report.limitations import limits
from freerock.report.numbers import KNOWN, NOT, USABLE, Number, Sentence, Tables, Where, listed, said
from freerock.tables.candidates import POSSIBLE, Answer, answers
from freerock.tables.number_text import printed_unit, quantity
from freerock.tables.printed_tables import U_NOTE, Labels

TABLES = ("runs", "choice", "candidates", "populations", "foundations", "predictions", "table1", "table3")
"""The tables that the findings are made from."""
OTHER_RUNS = "other runs"  # of the record, as the table predictions says
BASES = {OTHER_RUNS: "the other runs of a record", f"{NOT}{OTHER_RUNS}": "another block"}
MOST = 4  # names, laws or foundations that are listed
NAMED = {"status": "selected", "explains": True}


class Finding(NamedTuple):
    """A line of the findings: what it is about, its sentences, and whether these begin lines of their own."""

    head: str
    sentences: Sequence[Sentence]
    apart: bool = False


def findings(
    tables: Mapping[str, pd.DataFrame], labels: Labels, longest: Mapping[str, str] = MappingProxyType({})
) -> list[Finding]:
    """What was tested, what the foundation changes, what explains it, the parameters, how well they predict
    another run, what blocks share, what must not be concluded.

    Parameters
    ----------
    tables : mapping of str to pandas.DataFrame
        Those of `TABLES`, as `freerock.tables.csvfile.read_csv` gives them.
    labels : mapping of str to str
        Printed names of blocks and foundations.
    longest : mapping of str to str, optional
        Foundation on which each block rocks longest, as published.
    """
    known = Tables(tables)
    quoted = laws_of_foundations(known["choice"])
    told = [
        Finding("Tested", _tested(known, labels)),
        Finding("Foundation", _durations(known, labels, longest), True),
        Finding("Explained by", _explained(known)),
        Finding("Parameters", _parameters(known, quoted, labels), True),
        Finding("Predicted", _predicted(known, quoted, labels), True),
        Finding("Shared by blocks", _shared(known, quoted, labels), True),
        Finding("Not to be concluded", limits(known, set(filter(None, quoted.values())))),
    ]
    return [each for each in told if each.sentences]


def laws_of_foundations(choice: pd.DataFrame) -> dict[str, str]:
    """The candidate that explains most of the runs on each foundation; "" where none does.

    Parameters
    ----------
    choice : pandas.DataFrame
        Tidy table.
    """
    found = {}
    for foundation, own in choice.groupby("foundation", sort=False):
        named = own[(own["status"] == "selected") & own["explains"]]["model"].value_counts()
        most = len(named) and named.iloc[0] > len(own[["test", "run"]].drop_duplicates()) / 2
        found[str(foundation)] = str(named.index[0]) if most else ""
    return found


def _tested(known: Tables, labels: Labels) -> list[Sentence]:
    n_runs, records = known.count("runs", {"run": KNOWN}), known.count("runs", {}, "test")
    origin = " and ".join(dict.fromkeys(known["runs"]["origin"]))
    scene = said("{} on {}", _names(known, "block", labels), _names(known, "foundation", labels))
    if n_runs.text == "0":
        return [said("No run could be used: {} {} record{} of {}.", records, origin, _s(records), scene)]
    what = said("{} {} run{} in {} record{}: {}", n_runs, origin, _s(n_runs), records, _s(records), scene)
    if len(known.rows("runs", USABLE)):
        what = said("{}, released at {}°", what, known.ends("runs", "theta0_deg", USABLE, sizes=True))
    return [said("{}.", what), *_left_out(known)]


def _left_out(known: Tables) -> list[Sentence]:
    """Records and runs on which no number of the findings rests."""
    failed = known.rows("runs", {"verdict": "fail"})["run"]
    told: list[Sentence] = []
    if len(failed):
        n = known.count("runs", {"verdict": "fail"})
        kinds = [("record", failed.isna()), ("run", failed.notna())]
        told.append((n, f" {' or '.join(kind + _s(n) for kind, own in kinds if own.any())} failed"))
    n = known.count("runs", {"excluded": True})
    if n.text != "0":
        told.append((n, f" run{_s(n)} {'was' if n.text == '1' else 'were'} left out by hand"))
    return [(*listed(told), "; what follows does not rest on that.")] if told else []


def _durations(known: Tables, labels: Labels, longest: Mapping[str, str]) -> list[Sentence]:
    """How long each block rocks on each of several foundations where a law explains a run, longest first."""
    means = known.rows("runs", USABLE).groupby(["block", "foundation"], sort=False)["duration_s"].mean()
    explained = known.rows("choice", NAMED)[["block", "foundation"]].itertuples(index=False, name=None)
    means = means[means.index.isin([*explained])]
    blocks = list(dict.fromkeys(means.index.get_level_values("block")))
    told: list[Sentence] = []
    for block in [each for each in blocks if len(means[each]) > 1][:MOST]:
        ranked = means[block].sort_values(ascending=False, kind="stable")
        first, times = str(ranked.index[0]), list[Sentence]()
        for each in ranked.index:
            lasts = known.ends("runs", "duration_s", {**USABLE, "block": block, "foundation": each})
            times.append(said("{} s{}", lasts, "" if each == first else f" on {labels.get(each, each)}"))
        beside = {first: ", as published"}.get(longest.get(block, ""), "")
        if not beside and longest.get(block) in ranked:
            beside = ", unlike the published block"
        slender = known.value("table1", "slenderness", {"block": block})
        where = f"{labels.get(first, first)}{beside}"
        name = labels.get(block, block)
        told.append(said("{} (h/b = {}) rocks longest on {}: {}.", name, slender, where, listed(times)))
    return told and [*told, ("Each time ends where the motion is lost in the noise.",)]


def _predicted(known: Tables, quoted: Mapping[str, str], labels: Labels) -> list[Sentence]:
    """Largest discrepancy of runs with parameters of other runs, and of each block with those of others,
    under the law quoted, with the number of runs that were averaged."""
    told: list[Sentence] = []
    for foundation, model in list(quoted.items())[:MOST]:
        for basis, others in BASES.items():
            where: Where = {"foundation": foundation, "model": model, "basis": basis}
            blocks = list(known.rows("predictions", where)["block"].unique())
            if not blocks:
                continue
            label, most = labels.get(foundation, foundation), _at_most(known, where)
            if basis != OTHER_RUNS and len(blocks) <= MOST:
                each_most = [_at_most(known, {**where, "block": each}) for each in blocks]
                names = [labels.get(each, each) for each in blocks]
                most = listed([said("{} for {}", *pair) for pair in zip(each_most, names, strict=True)])
            n = known.ends("predictions", "n_runs", where)
            told.append(said("{}, from {} ({} averaged): ε_θ ≤ {}.", label, others, n, most))
    return told


def _at_most(known: Tables, where: Where) -> Sentence:
    """The largest discrepancy of some predictions."""
    return known.most("predictions", "epsilon_theta", where, 100), " %"


def _explained(known: Tables) -> list[Sentence]:
    found = answers(known["choice"])
    if not found:
        return [("No law was fitted to any run.",)]
    n, told = known.count("choice", {}, "test", "run"), list[Sentence]()
    named = Counter(each.model for each in found if each.explained)
    counted = [
        said("{} explains {}", MODEL_LABELS[model], _of(known.count("choice", NAMED | {"model": model}), n))
        for model, _ in named.most_common(MOST)
    ]
    if counted:
        more = ", further laws some of the others" if len(named) > MOST else ""
        residual = "its residual agrees" if len(named) == 1 else "their residuals agree"
        told.append(said("{}{}: {} with the noise of the sensor.", listed(counted), more, residual))
        told.append(_as_possible(known, found))
    if lost := [each for each in found if not each.explained]:
        told += _unexplained(lost, n)
    elif rejected := list(_rejected(known)):
        more = "; further laws: appendix" if len(rejected) > MOST else ""
        told.append(
            said(
                "Rejected (in brackets the median ε_θ of each record, or the runs): {}{}.",
                listed(rejected[:MOST]),
                more,
            )
        )
    return told


def _as_possible(known: Tables, found: Sequence[Answer]) -> Sentence:
    """What else could explain the runs that are explained."""
    counted = Counter(model for each in found if each.explained for model in each.others)
    if not counted:
        fitted = known.rows("choice", {"status": "rejected", "explains": True})
        if fitted.empty:
            return ("No other law that was fitted explains a run.",)
        return ("Of the other laws that were fitted, none does as well with as few parameters.",)
    others: list[Sentence] = []
    for model, times in counted.most_common(MOST):
        n = known.count("choice", {"model": model, "status": "also_possible"})
        others.append(said("{} in {} run{}", MODEL_LABELS[model], n, "s" * (times > 1)))
    more = " or others" if len(counted) > MOST else ""
    return said("The data can't tell it from {}{}.", listed(others, "or"), more)


def _unexplained(lost: Sequence[Answer], n: Number) -> Iterator[Sentence]:
    whom: Sentence = ("the others",)
    if len(lost) == int(n.text):
        whom = ("any of the ", n, " runs") if len(lost) > 1 else ("the only run",)
    yield ("No law explains ", *whom, ": the residual exceeds the noise, or an input would have to be wrong.")
    counted = Counter(each.model for each in lost if each.model)
    if nearest := [MODEL_LABELS[model] for model, _ in counted.most_common(2)]:
        come = "comes nearest; its" if len(nearest) == 1 else "come nearest; their"
        yield (f"{' and '.join(nearest)} {come} parameters then describe the fit alone.",)


def _rejected(known: Tables) -> Iterator[Sentence]:
    """The laws that are rejected on all runs that they were fitted to; of the paper's the discrepancy, from
    record to record."""
    for model in CANDIDATES:
        own = known.rows("candidates", {"model": model})
        if not own["n_rejected"].sum() or (own["n_rejected"] + own["n_not_fitted"] < own["n_runs"]).any():
            continue
        if model not in PAPER_MODELS:
            n = known.count("choice", {"model": model, "status": "rejected"})
            yield said("{} (in {} run{})", MODEL_LABELS[model], n, _s(n))
            continue
        usable: Where = {"model": model, "success": True}
        n_usable = known.rows("table3", usable)["n_runs"].sum()
        if not n_usable:
            yield (f"{MODEL_LABELS[model]} (all fits failed)",)
            continue
        some = "; some fits failed" if n_usable < (own["n_runs"] - own["n_not_fitted"]).sum() else ""
        ends = known.ends("table3", "epsilon_theta", usable, 100)
        yield said("{} ({} %{})", MODEL_LABELS[model], ends, some)


def _parameters(known: Tables, quoted: Mapping[str, str], labels: Labels) -> list[Sentence]:
    told, without, of_one = list[Sentence](), list[Sentence](), False
    for foundation, model in list(quoted.items())[:MOST]:
        label = labels.get(foundation, foundation)
        if not model:
            without.append((label,))
            continue
        rows, records = _best_known(known, foundation, model), _explained_records(known, foundation, model)
        names, own = CANDIDATES[model].parameters, _of_each_record(known, rows)
        of_law = [_number(known, {**rows, "parameter": name}, labels) for name in names if name not in own]
        law = said("{}, {}", MODEL_LABELS[model], _over(known, rows))
        of_foundation = said("{}: {} ({})", label, listed(of_law), law)
        for name in own:
            of_records: Where = {**records, "parameter": name}
            if len(known.rows("populations", of_records)):
                each = _of_records(known, of_records, labels)
                of_foundation = said("{}; of each record its own {}", of_foundation, each)
        told.append(said("{}.", of_foundation))
        of_one |= bool((known.rows("populations", rows)["n_runs"] == 1).any())
    if without:
        told.append(("None on ", *listed(without), ": no law explains most of the runs there."))
    if len(quoted) > MOST:
        told.append(("The other foundations: table of parameters.",))
    if any(quoted.values()):
        more = "; one run does not show the scatter between runs" * of_one
        told.append((f"{U_NOTE} runs, noise, block, sensor, clock and law{more}.",))
    return told or [("None, as no run was fitted.",)]


def _best_known(known: Tables, foundation: str, model: str) -> Where:
    """Which rows of the populations tell a foundation's parameters: its own unless blocks differ."""
    of_foundation = {"foundation": foundation, "model": model}
    whole = of_foundation | {"level": "foundation"}
    if len(known.rows("populations", whole)) and known.rows("foundations", of_foundation)["transfers"].all():
        return whole
    return _explained_records(known, foundation, model)


def _explained_records(known: Tables, foundation: str, model: str) -> Where:
    """Which rows of the populations are of the records on a foundation that a law explains."""
    own: Where = {"foundation": foundation, "model": model}
    explained = known.rows("choice", {**own, "status": POSSIBLE, "explains": True})
    return {**own, "level": "record", "test": tuple(explained["test"].unique())}


def _of_each_record(known: Tables, rows: Where) -> list[str]:
    """The parameters of a record among those of a foundation: over several records they have no mean."""
    names = known.rows("populations", rows)["parameter"]
    return [name for name in names if name in OF_RECORD] if rows["level"] == "foundation" else []


def _of_records(known: Tables, where: Where, labels: Labels) -> Sentence:
    """A parameter of each of a few records, or its range over more."""
    own, symbol = known.rows("populations", where), f"{SYMBOLS[str(where['parameter'])]} = "
    if len(own) > MOST:
        unit, factor = printed_unit(own["unit"].iloc[0])
        ends = known.ends("populations", "mean", where, factor)
        return said("{}{}{}{}", symbol, ends, unit, _of_width(known, where))
    names = own["block"] if own["block"].is_unique else own["test"]
    each = [
        said(
            "{} ({})",
            known.value("populations", "mean", {**where, "test": test}, "u_total"),
            labels.get(name, name),
        )
        for test, name in zip(own["test"], names, strict=True)
    ]
    return symbol, *listed(each), *_of_width(known, where)


def _of_width(known: Tables, where: Where) -> Sentence:
    """A fitted distance of the corners in per cent of the block's width: the lowest and the highest."""
    if where["parameter"] != "width":
        return ()
    widths = known["table1"].set_index("block")["width_m"]
    shares = []
    for row in known.rows("populations", where).itertuples():
        factor = 100 / widths[row.block]
        of_record = {**where, "level": "record", "test": row.test}
        text = quantity(factor * row.mean, digits=3)
        shares.append((factor * row.mean, Number(text, "populations", ("mean",), of_record, factor=factor)))
    ends = [end(shares, key=lambda each: each[0])[1] for end in (min, max)]
    apart: Sentence = (ends[0],) if ends[0].text == ends[1].text else (ends[0], " to ", ends[1])
    return ", ", *apart, " % of the block's width"


def _number(known: Tables, where: Where, labels: Labels) -> Sentence:
    """A parameter of one record or of a foundation; that of each record where these have their own."""
    own, parameter = known.rows("populations", where), str(where["parameter"])
    if own.empty:
        return (f"{SYMBOLS[parameter]} unknown",)
    if len(own) == 1:
        mean = known.value("populations", "mean", where, "u_total")
        return f"{SYMBOLS[parameter]} = ", mean, *_of_width(known, where)
    return _of_records(known, where, labels)


def _over(known: Tables, rows: Where) -> Sentence:
    """Over what a parameter was averaged, or ranges."""
    if rows["level"] == "foundation":
        first = known.rows("populations", rows)["parameter"].iloc[0]
        return "mean of ", known.value("populations", "n_records", {**rows, "parameter": first}), " records"
    records = known.count("populations", rows, "test")
    if records.text == "1":
        return ("one record",)
    return "range over " * (int(records.text) > MOST), records, " records"


def _shared(known: Tables, quoted: Mapping[str, str], labels: Labels) -> list[Sentence]:
    told = [
        _agree(known, labels.get(foundation, foundation), {"foundation": foundation, "model": model})
        for foundation, model in quoted.items()
        if len(known.rows("foundations", {"foundation": foundation, "model": model}))
    ][:MOST]
    if told:
        return told
    several = known["runs"].groupby("foundation")["block"].nunique() > 1
    if not several.any():
        return [("Not tested: each foundation carried one block only.",)]
    rigid = any(model and not law_of(model).is_foundation for model in quoted.values())
    if rigid:
        return [("Not asked: r belongs to the block, not to the foundation.",)]
    return [("Not known: no law explains runs of several blocks on one foundation.",)]


def _agree(known: Tables, label: str, scene: Where) -> Sentence:
    """Whether the mean of a foundation holds for another block, and by how much its records scatter."""
    rows = known.rows("foundations", scene)
    symbols = " and ".join(SYMBOLS[each] for each in rows["parameter"])
    records = known.value("foundations", "n_records", {**scene, "parameter": rows["parameter"].iloc[0]})
    apart = rows[~rows["transfers"].astype(bool)]
    if apart.empty:
        return said("{}: {} of {} records agree within their uncertainties.", label, symbols, records)
    each = []
    for name in apart["parameter"]:
        where = {**scene, "parameter": name}
        tau = known.value("foundations", "tau", where, digits=2)
        chance = apart.loc[apart["parameter"] == name, "scatter_p"].item()
        p = Number(quantity(chance, digits=2), "foundations", ("scatter_p",), where)
        each.append(said("{} scatters by τ = {} (p = {})", SYMBOLS[name], tau, p))
    told = "{}: over {} records {}: it does not transfer to another block."
    return said(told, label, records, listed(each))


def _names(known: Tables, kind: str, labels: Labels) -> Sentence:
    """The blocks or foundations of the records: their names, or how many there are."""
    names = list(dict.fromkeys(known["runs"][kind]))
    if len(names) > MOST:
        return known.count("runs", {}, kind), f" {kind}s"
    return listed([(labels.get(name, name),) for name in names])


def _of(count: Number, n: Number) -> Sentence:
    if count.text == n.text:
        return ("the only run",) if n.text == "1" else ("all ", n, " runs")
    return count, " of ", n, " runs"


def _s(count: Number) -> str:
    return "" if count.text == "1" else "s"
