"""The figures of a campaign in LaTeX, and a document of the paper's tables and figures."""

from collections.abc import Mapping

from freerock.tables.latex import tex
from freerock.tables.number_text import SIMULATED_NOTE

OF_PAPER = ("foundation_effect", "comparison")  # figures 2 and 3 of Spanos et al. 2017
MOST_HIGH = 0.76  # a figure over the text of a page: its caption needs the rest


def figures_tex(captions: Mapping[str, tuple[str, str]]) -> str:
    r"""The figures of a campaign with their captions, for a paper.

    Parameters
    ----------
    captions : mapping of str to (str, str)
        Title and text of each, by the name of its file.

    Returns
    -------
    str
        A figure across both columns for each, labelled `fig:NAME`; the document needs graphicx, and
        `\graphicspath` where the figures lie elsewhere.
    """
    lines = list[str]()
    for name, (title, text) in captions.items():
        told = title.removesuffix(".") + " (simulated records)" * (SIMULATED_NOTE in text)
        lines += [
            r"\begin{figure*}",
            r"\centering",
            rf"\includegraphics[width=\linewidth,height={MOST_HIGH}\textheight,keepaspectratio]{{{name}}}",
            rf"\caption{{\textbf{{{tex(told)}.}} {tex(text.replace(SIMULATED_NOTE, '').rstrip())}}}",
            rf"\label{{fig:{name}}}",
            r"\end{figure*}",
            "",
        ]
    return "\n".join(lines)


def paper_tex(captions: Mapping[str, tuple[str, str]], n_foundations: int) -> str:
    r"""A document of tables 1 to 3 and figures 2 and 3, to be typeset beside Spanos et al. 2017.

    Parameters
    ----------
    captions : mapping of str to (str, str)
        Title and text of each figure, by the name of its file in `../figures`.
    n_foundations : int
        How many there are: figure 2 compares them.
    """
    names = OF_PAPER[n_foundations < 2 :]
    lines = [
        r"\documentclass[twocolumn]{article}",
        r"\usepackage{booktabs,graphicx,siunitx}",
        r"\graphicspath{{../figures/}}",
        r"\renewenvironment{table}{\csname table*\endcsname}{\csname endtable*\endcsname}",  # across the page
        r"\begin{document}",
        *(rf"\input{{table{n}}}" for n in (1, 2, 3)),
        rf"\setcounter{{figure}}{{{3 - len(names)}}}",
        figures_tex({name: captions[name] for name in names}),
        r"\end{document}",
        "",
    ]
    return "\n".join(lines)
