"""Printed tables in LaTeX, and the numbers of a campaign as LaTeX macros."""

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import pandas as pd

from freerock.tables.paper import SIMULATED_NOTE
from freerock.tables.text import fixed, quantity, unit_text

DIGITS = ("Zero", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine")
SMALL = "alpha beta gamma delta zeta eta theta iota kappa mu nu xi pi rho sigma tau upsilon phi chi psi omega"
CAPITAL = "Gamma Delta Theta Xi Pi Sigma Upsilon Phi Psi Omega"
GREEK = {
    unicodedata.lookup(f"GREEK {size} LETTER {name}"): rf"$\{name}$"
    for size, names in (("SMALL", SMALL), ("CAPITAL", CAPITAL))
    for name in names.split()
}
TEX = {
    **GREEK,
    **{char: rf"\{char}" for char in "&%$#_{}"},
    **{"<": "$<$", ">": "$>$"},
    **{"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"},
    **{
        "…": r"\ldots{}",
        "±": r"$\pm$",
        "·": r"$\cdot$",
        "−": "$-$",
        "×": r"$\times$",
        "≤": r"$\leq$",
        "≥": r"$\geq$",
        "≈": r"$\approx$",
        "°": r"$^\circ$",
        "–": "--",
        "†": r"$\dagger$",
        "‡": r"$\ddagger$",
        "’": "'",
    },
    **{"λ": r"$\lambda$", "Λ": r"$\Lambda$", "ε": r"$\varepsilon$", "ε_θ": r"$\varepsilon_\theta$"},
    **{"t_f": "$t_f$", "θ₀": r"$\theta_0$", "t₀": "$t_0$"},
}
_TEX_TOKEN = re.compile(
    r"[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+|[₀₁₂₃₄₅₆₇₈₉]+|\bt_f\b|"
    + "|".join(re.escape(key) for key in sorted({*TEX} - {"t_f"}, key=len, reverse=True))
)
_NORMAL_DIGITS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹₀₁₂₃₄₅₆₇₈₉", "-01234567890123456789")


def latex(text: pd.DataFrame, caption: str, notes: Sequence[str] = ()) -> str:
    """A printed table as LaTeX; the document needs no package but booktabs.

    Parameters
    ----------
    text : pandas.DataFrame
        Printed cells.
    caption : str
        Caption.
    notes : sequence of str
        Footnotes.
    """
    font = "small" if len(text.columns) <= 6 else "scriptsize"
    rows = [" & ".join(map(_tex, row)) + r" \\" for row in [list(text.columns), *text.values.tolist()]]
    return "\n".join(
        [
            r"\begin{table}",
            rf"\centering\{font}\setlength{{\tabcolsep}}{{2.5pt}}",
            rf"\caption{{{_tex(caption)}}}",
            rf"\begin{{tabular}}{{{'l' * len(text.columns)}}}",
            r"\toprule",
            rows[0],
            r"\midrule",
            *rows[1:],
            r"\bottomrule",
            r"\end{tabular}",
            *(rf"\par\footnotesize {_tex(note)}" for note in notes),
            r"\end{table}",
            "",
        ]
    )


def numbers_tex(tidy: Mapping[str, pd.DataFrame]) -> str:
    r"""Every fitted number as a LaTeX macro, for the text of a paper.

    Parameters
    ----------
    tidy : mapping of str to pandas.DataFrame
        The tidy tables runs, parameters, epsilon and populations.

    Returns
    -------
    str
        A file to `\input`: `\frRecords`, `\frRuns`; of each record the mean parameters of its runs with
        standard error and unit, as `\frConfigTwoMarbleHuntCrossleyK`, and the median discrepancy; of each fit
        its parameters, discrepancy and t_f, with `RunOne` before the model. The numbers of a fit that may
        not be used are the words "failed fit".
    """
    runs, named = tidy["runs"], dict[str, str]()

    def macro(parts: Iterable[str], text: object) -> None:
        named["fr" + "".join(parts)] = _tex(text)

    macro(["Records"], runs["test"].nunique())
    macro(["Runs"], runs["run"].notna().sum())
    populations = tidy["populations"]
    for row in populations[populations["level"] == "record"].itertuples():
        value = f"{quantity(row.mean, row.u_total)} {unit_text(row.unit)}".rstrip()
        macro([spelt_test(row.test), *map(_letters, (row.model, row.parameter))], value)
    usable = tidy["epsilon"][tidy["epsilon"]["success"]]
    for (test, model), epsilon in usable.groupby(["test", "model"], sort=False)["epsilon_theta"]:
        macro([spelt_test(test), _letters(model), "Epsilon"], f"{quantity(100 * epsilon.median())} %")
    for row in tidy["parameters"].itertuples():
        value = f"{quantity(row.value, row.u_total)} {unit_text(row.unit)}".rstrip()
        macro([*_fit_name(row), _letters(row.parameter)], value if row.success else "failed fit")
    for row in tidy["epsilon"].itertuples():
        text = f"{quantity(100 * row.epsilon_theta)} %"
        macro([*_fit_name(row), "Epsilon"], text if row.success else "failed fit")
        macro([*_fit_name(row), "FinalTime"], f"{fixed(row.final_time_s, 2)} s")
    notes = [f"% {SIMULATED_NOTE}"] if "simulated" in set(runs["origin"]) else []
    lines = [rf"\newcommand{{\{name}}}{{{text}}}" for name, text in named.items()]
    return "\n".join([*notes, *lines, ""])


def figures_tex(captions: Mapping[str, tuple[str, str]]) -> str:
    r"""The figures of a campaign with their captions, for a paper.

    Parameters
    ----------
    captions : mapping of str to (str, str)
        Title and text of each, by the name of its file.

    Returns
    -------
    str
        A figure environment for each, labelled `fig:NAME`; the document needs graphicx, and
        `\graphicspath` where the figures lie elsewhere.
    """
    environments = [
        "\n".join(
            [
                r"\begin{figure}",
                r"\centering",
                rf"\includegraphics[width=\linewidth]{{{name}}}",
                rf"\caption{{\textbf{{{_tex(title)}}} {_tex(text)}}}",
                rf"\label{{fig:{name}}}",
                r"\end{figure}",
                "",
            ]
        )
        for name, (title, text) in captions.items()
    ]
    return "\n".join(environments)


def _fit_name(row: Any) -> list[str]:
    return [spelt_test(row.test), "Run", _letters(str(row.run)), _letters(row.model)]


def spelt_test(name: str) -> str:
    """A test's name in letters alone, as no other is spelt: "config2_marble" is ConfigTwoMarble.

    Names of another form than words in lower case, each with its number, end in Q and their bytes as letters
    from a to p; so do those that end as a run or as such a name.
    """
    spelt = _letters(name)
    words = re.findall("[A-Z][a-z]*", spelt)
    plain = "".join(str(DIGITS.index(word)) if word in DIGITS else f"_{word.lower()}" for word in words)
    taken = re.search(rf"Run({'|'.join(DIGITS)})+$|Q[a-p]*$", spelt)
    if plain.removeprefix("_") == name and not taken:
        return spelt
    return spelt + "Q" + name.encode().hex().translate(str.maketrans("0123456789abcdef", "abcdefghijklmnop"))


def _letters(name: str) -> str:
    """A name in letters alone, as LaTeX's macros want it: "config2_marble" is ConfigTwoMarble."""
    spelled = re.sub(r"\d", lambda digit: f"_{DIGITS[int(digit[0])]}_", name)
    words = re.findall("[a-zA-Z]+", spelled)
    return "".join(word[0].upper() + word[1:] for word in words)


def _tex(text: object) -> str:
    def command(match: re.Match[str]) -> str:
        place = "_" if match[0][0] in "₀₁₂₃₄₅₆₇₈₉" else "^"
        return TEX.get(match[0]) or f"${place}{{{match[0].translate(_NORMAL_DIGITS)}}}$"

    return _TEX_TOKEN.sub(command, " ".join(str(text).split()))
