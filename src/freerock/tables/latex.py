"""Printed tables in LaTeX, and the numbers of a campaign as LaTeX macros."""

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence

import pandas as pd

from freerock.tables.choices import rejected_laws
from freerock.tables.number_text import SIMULATED_NOTE, quantity, value_text

DIGITS = ("Zero", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine")
SMALL = "alpha beta gamma delta zeta eta theta iota kappa mu nu xi pi rho sigma tau upsilon phi chi psi omega"
CAPITAL = "Gamma Delta Theta Xi Pi Sigma Upsilon Phi Psi Omega"
GREEK = {
    unicodedata.lookup(f"GREEK {size} LETTER {name}"): rf"$\{name}$"
    for size, names in (("SMALL", SMALL), ("CAPITAL", CAPITAL))
    for name in names.split()
}
MATH_SIGNS = "±·×≤≥≈†‡§λΛε"
MATH_NAMES = "pm cdot times leq geq approx dagger ddagger S lambda Lambda varepsilon"
TEX = {
    **GREEK,
    **{sign: rf"$\{name}$" for sign, name in zip(MATH_SIGNS, MATH_NAMES.split(), strict=True)},
    **{char: rf"\{char}" for char in "&%$#_{}"},
    **{"<": "$<$", ">": "$>$"},
    **{"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"},
    **{"…": r"\ldots{}", "−": "$-$", "°": r"$^\circ$", "–": "--", "’": "'"},
    **{"ε_θ": r"$\varepsilon_\theta$", "θ₀": r"$\theta_0$", "θ_cr": r"$\theta_\mathrm{cr}$"},
    **{"t_f": "$t_f$", "t₀": "$t_0$", "k̄": r"$\bar{k}$", "σ_r": r"$\sigma_r$", " %": r"~\%"},
}
_TEX_TOKEN = re.compile(
    r"[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+|[₀₁₂₃₄₅₆₇₈₉ₙ]+|\bt_f\b|"
    + "|".join(re.escape(key) for key in sorted({*TEX} - {"t_f"}, key=len, reverse=True))
)
_NORMAL_DIGITS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹₀₁₂₃₄₅₆₇₈₉ₙ", "-01234567890123456789n")


COLUMN_PT, SIZE_PT = 229.5, 9.0  # of `article` in two columns: width of one, and size of \\small
WIDE = 0.56  # width of a character over the size of its font, in Computer Modern, at most on the mean
GAPS = 2.5, 12.0  # on either side of a column, at least, and of all columns [pt]
_NUMBER = re.compile(  # with a standard error, a power of ten or both; others are set as they are
    r"\(−?[\d.]+ ± [\d.]+\)·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+|(?<![\d.(])−?[\d.]+·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+|−?[\d.]+ ± [\d.]+"
)
_UNIT = re.compile(r"(?<= / \()[^()]+(?=\)$)|(?<= / )[a-z]+$")
_ITALIC = re.compile(r"^(r|k|c|p|R|m|h/b|2h|2b)(?= / |$| \(Housner\)$)|(?<!\w)[rkc](?= [=<] | in )")


def latex(text: pd.DataFrame, caption: str, notes: Sequence[str] = (), label: str = "") -> str:
    """A printed table as LaTeX; the document needs the packages booktabs, graphicx and siunitx.

    It is as wide as a column where it fits, else as a page in two columns, and shrinks to that.

    Parameters
    ----------
    text : pandas.DataFrame
        Printed cells; a row with nothing but its first cell is a heading across the table.
    caption : str
        Caption.
    notes : sequence of str
        Footnotes.
    label : str
        By which the document refers to it; empty for none.
    """
    lines = [[*text.columns], *text.values.tolist()]
    cells = [[" ".join(str(cell).split()) for cell in line] for line in lines]
    across = [len(row) > 1 and bool(row[0]) and not any(row[1:]) for row in cells]
    inside = [row for row, alone in zip(cells, across, strict=True) if not alone]
    widths = [max(map(len, column)) for column in zip(*inside, strict=True)]
    gap = round(max(GAPS[0], GAPS[1] / len(widths)), 1)
    wide = WIDE * SIZE_PT * sum(widths) + 2 * gap * len(widths) > COLUMN_PT
    environment = "table*" if wide else "table"
    rows = [
        rf"\addlinespace[2pt]\multicolumn{{{len(row)}}}{{@{{}}l}}{{\emph{{{tex(row[0])}}}}} \\"
        if alone
        else " & ".join(map(_cell, row)) + r" \\"
        for row, alone in zip(cells, across, strict=True)
    ]
    written = [
        rf"\begin{{{environment}}}",
        rf"\centering\small\setlength{{\tabcolsep}}{{{gap}pt}}",
        r"\sisetup{separate-uncertainty=true, exponent-product=\cdot}",
        rf"\caption{{{tex(caption)}}}",
        *([rf"\label{{{label}}}"] if label else []),
        rf"\setbox0=\hbox{{\begin{{tabular}}{{@{{}}{'l' * len(widths)}@{{}}}}",
        r"\toprule",
        rows[0],
        r"\midrule",
        *rows[1:],
        r"\bottomrule",
        r"\end{tabular}}",
        r"\leavevmode\ifdim\wd0>\linewidth\resizebox{\linewidth}{!}{\box0}\else\box0\fi",
        *([rf"\par\smallskip\footnotesize {' '.join(map(_cell, notes))}"] if notes else []),
        rf"\end{{{environment}}}",
        "",
    ]
    return "\n".join(written)


def _cell(text: str) -> str:
    """A cell: numbers and units by siunitx, symbols of quantities in italics."""
    parts, end = list[str](), 0
    found = [*_ITALIC.finditer(text), *_UNIT.finditer(text)]
    found += _NUMBER.finditer(text)
    for match in sorted(found, key=re.Match.start):
        parts += [tex(text[end : match.start()]), _set(match)]
        end = match.end()
    return "".join([*parts, tex(text[end:])])


def _set(match: re.Match[str]) -> str:
    """A symbol, unit or number as LaTeX sets it."""
    if match.re is _ITALIC:
        return f"${match[0]}$"
    if match.re is _UNIT:
        unit = re.sub(r"[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+", lambda m: f"^{{{m[0].translate(_NORMAL_DIGITS)}}}", match[0])
        unit = unit.replace("°", r"\degree").replace(" ", ".")
        return rf"\unit{{{unit}}}"
    value, _, power = match[0].partition("·10")
    exponent = f"e{power.translate(_NORMAL_DIGITS)}" if power else ""
    return rf"\num{{{value.strip('()').replace('−', '-').replace('±', '+-')}{exponent}}}"


def numbers_tex(tidy: Mapping[str, pd.DataFrame]) -> str:
    r"""Means and ε_θ as LaTeX macros, for the text of a paper.

    Parameters
    ----------
    tidy : mapping of str to pandas.DataFrame
        The tidy tables runs, epsilon, choice and populations.

    Returns
    -------
    str
        A file to `\input`: `\frRecords`, `\frRuns`; of each record the mean parameters of its runs with
        u_total and unit, as `\frConfigTwoMarbleHuntCrossleyK`, and the median ε_θ; of each foundation
        the mean over its records, as `\frmeanMarbleHuntCrossleyK` (no test begins in lower case). None of a
        law that the runs of a block on a foundation reject, of a mean those of all blocks.
    """
    runs, named = tidy["runs"], dict[str, str]()

    def macro(parts: Iterable[str], text: object) -> None:
        name = "fr" + "".join(parts)
        while name in named:  # of tests such as a_1 and a1
            name += "X"
        named[name] = tex(text)

    macro(["Records"], runs["test"].nunique())
    macro(["Runs"], runs["run"].notna().sum())
    rejected = rejected_laws(tidy["choice"])
    populations = tidy["populations"]
    for row in populations[populations["level"] != "campaign"].itertuples():
        if (row.block if row.level == "record" else "", row.foundation, row.model) in rejected:
            continue
        value = value_text(row.mean, row.u_total, row.unit)
        of = _letters(row.test) if row.level == "record" else f"mean{_letters(row.foundation)}"
        macro([of, *map(_letters, (row.model, row.parameter))], value)
    usable = tidy["epsilon"][tidy["epsilon"]["success"]]
    for (test, *law), own in usable.groupby(["test", "block", "foundation", "model"], sort=False):
        if tuple(law) not in rejected:
            text = f"{quantity(100 * own['epsilon_theta'].median())} %"
            macro([_letters(test), _letters(law[-1]), "Epsilon"], text)
    notes = [f"% {SIMULATED_NOTE}"] * ("simulated" in set(runs["origin"]))
    notes.append("% Epsilon: of fits with inputs and impacts free; table 3 has the paper's own procedure.")
    lines = [rf"\newcommand{{\{name}}}{{{text}}}" for name, text in named.items()]
    return "\n".join([*notes, *lines, ""])


def _letters(name: str) -> str:
    """A name in letters alone, as LaTeX's macros want it: "config2_marble" is ConfigTwoMarble."""
    spelled = re.sub(r"\d", lambda digit: f"_{DIGITS[int(digit[0])]}_", name)
    words = re.findall("[a-zA-Z]+", spelled)
    return "".join(word[0].upper() + word[1:] for word in words)


def tex(text: object) -> str:
    """A text with the signs that steer LaTeX escaped."""

    def command(match: re.Match[str]) -> str:
        place = "_" if match[0][0] in "₀₁₂₃₄₅₆₇₈₉ₙ" else "^"
        return TEX.get(match[0]) or f"${place}{{{match[0].translate(_NORMAL_DIGITS)}}}$"

    return _TEX_TOKEN.sub(command, re.sub(r"\s+", " ", str(text)))
