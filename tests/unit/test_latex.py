import re
import shutil
import subprocess

import numpy as np
import pandas as pd
import pytest
from fabricated import campaign, tidy_tables
from matplotlib.image import imsave
from reported import tables_of

from freerock.figures.listed import FIGURES, entry_of
from freerock.models.block import Block
from freerock.report.document import figures_tex, paper_tex
from freerock.report.printed import printed_tables
from freerock.tables.latex import latex, numbers_tex, tex
from freerock.tables.number_text import SIMULATED_NOTE, quantity
from freerock.tables.paper import table1
from freerock.tables.populations import means_in, populations_table


@pytest.fixture(scope="module")
def datasets():
    return campaign()


def has_latex():
    return (
        shutil.which("pdflatex")
        and not subprocess.run(["kpsewhich", "siunitx.sty"], stdout=subprocess.DEVNULL).returncode
    )


def test_latex_sets_symbols_in_italics_and_numbers_by_siunitx():
    cells = {
        "Parameter": ["r", "k / (N m⁻²)", "2b / m", "Hunt–Crossley ‡"],
        "Identified": ["0.9570 ± 0.0012", "k = 6.88·10⁶", "−1.5·10⁻³", "3 runs"],
    }
    text = latex(pd.DataFrame(cells), "Parameters", label="tab:x")
    assert r"$r$ & \num{0.9570 +- 0.0012} \\" in text
    assert r"$k$ / (\unit{N.m^{-2}}) & $k$ = \num{6.88e6} \\" in text
    assert r"$2b$ / \unit{m} & \num{-1.5e-3} \\" in text
    assert r"Hunt--Crossley $\ddagger$ & 3 runs \\" in text
    assert text.count(r"\sisetup{separate-uncertainty=true, exponent-product=\cdot}") == 1
    assert text.index(r"\caption") < text.index(r"\label{tab:x}") < text.index(r"\begin{tabular}")


def test_latex_sets_indices_and_keeps_the_percent_at_its_number():
    assert tex("95 % 5%") == r"95~\% 5\%"
    assert tex("σ_r, ε_θ, θ_cr") == r"$\sigma_r$, $\varepsilon_\theta$, $\theta_\mathrm{cr}$"


def test_a_value_without_u_has_no_more_digits_than_are_asked_for():
    assert [quantity(each) for each in (9843, 986, 14900)] == ["9.84·10³", "986", "1.49·10⁴"]
    assert quantity(7140.2, digits=4) == "7140" and quantity(9843, 12) == "9843 ± 12"


def test_numbers_are_macros_of_letters_alone(datasets):
    tidy = tidy_tables(*datasets)
    tidy["parameters"].loc[tidy["parameters"]["test"] == "b2_mat", "success"] = False
    tidy["populations"] = populations_table(means_in(tidy["parameters"]))
    own = tidy["epsilon"]["test"].eq("b1_marble") & tidy["epsilon"]["model"].eq("winkler")
    tidy["epsilon"].loc[own, "epsilon_theta"] = [0.01, 0.03]
    lines = numbers_tex(tidy).splitlines()
    assert lines[0].startswith("% The records are simulated")
    names = [re.fullmatch(r"\\newcommand\{\\(fr[a-zA-Z]+)\}\{.+\}", line)[1] for line in lines[2:]]
    populations, epsilon = tidy["populations"], tidy["epsilon"]
    told = (populations["level"] != "campaign") & (populations["model"] == "hunt_crossley")
    n_epsilon = epsilon.query("model == 'hunt_crossley'")["test"].nunique()
    assert len(set(names)) == len(names) == 2 + told.sum() + n_epsilon  # runs reject the other laws
    assert not any("Housner" in name or "Winkler" in name for name in names)
    assert r"\newcommand{\frRuns}{9}" in lines
    assert any(line.startswith(r"\newcommand{\frmeanMarbleHuntCrossleyK}{(6.88") for line in lines)
    choice = tidy["choice"]
    of_block = (choice["block"] == "b1") & (choice["foundation"] == "marble") & (choice["model"] == "winkler")
    choice.loc[choice.index[of_block][0], "status"] = "also_possible"
    lines = [line for line in numbers_tex(tidy).splitlines() if "Winkler" in line]
    named = {re.search(r"\\(fr\w+)", line)[1] for line in lines}
    of_record = {f"frBOneMarbleWinkler{each}" for each in ("K", "C", "Epsilon")}
    assert named == of_record | {"frmeanMarbleWinklerK", "frmeanMarbleWinklerC"}
    assert r"\newcommand{\frBOneMarbleWinklerEpsilon}{2.00~\%}" in lines


@pytest.mark.skipif(not has_latex(), reason="needs pdflatex with booktabs and siunitx")
@pytest.mark.parametrize("name", ["Configuration #2", "A block of a longer name than others"])
def test_tables_fit_the_columns_of_a_journal(tmp_path, datasets, name):
    shapes = {f"b{i}": Block(0.28, 0.07, 5.84) for i in range(1, 7)}
    frames = tables_of(tmp_path, datasets)
    labels = {"b1": name, "mat": "Mat 100 % & more"}
    printed = printed_tables(frames, "simulated", doi="10.1/2", labels=labels)
    wide = frames | {"table1": table1(datasets[0], shapes)}
    tables = {each: table.text for each, table in printed.items()} | {
        "blocks": printed_tables(wide, "simulated", labels=labels)["table1"].text,
    }
    for stem, text in tables.items():
        written = latex(text, "Of θ₀ ± 5 %", ["A note."], f"tab:{stem}")
        (tmp_path / f"{stem}.tex").write_text(written, encoding="utf-8")
    (tmp_path / "numbers.tex").write_text(numbers_tex(tidy_tables(*datasets)), encoding="utf-8")
    refer = " ".join(rf"\ref{{tab:{stem}}}" for stem in tables)
    log = compiles(
        tmp_path, "booktabs,graphicx,siunitx", ["numbers", *tables], rf"\frBOneMarbleHuntCrossleyK {refer}"
    )
    assert not re.findall(r"Overfull \\hbox \([\d.]+pt", log)
    assert "Float too large" not in log


@pytest.mark.skipif(not has_latex(), reason="needs pdflatex with booktabs")
def test_captions_of_all_figures_compile_with_graphicx_alone(tmp_path):
    drawn = (
        "Drawn: run\N{NO-BREAK SPACE}1 of b_1 and run 2 of a-b. Law: Hunt–Crossley, named by 3 of 18 runs."
    )
    label = "Größe Ø 5 % & more_#1 {a} ~^\\ $x$ “µ” β₂ ≤ 3 × 10⁻³"
    lines = {name: entry_of(name) for name in FIGURES}
    told = {name: (f"{line['title']} {label}", f"{line['caption']} {drawn}") for name, line in lines.items()}
    for name in told:
        imsave(tmp_path / f"{name}.png", np.zeros((24, 30, 3)))
    (tmp_path / "captions.tex").write_text(figures_tex(told), encoding="utf-8")
    compiles(tmp_path, "graphicx", ["captions"])


def test_the_papers_set_has_figure_2_where_foundations_are_compared_and_says_simulated():
    told = {name: ("A title.", "What is drawn.") for name in FIGURES}
    told["comparison"] = ("Laws.", f"What is drawn. {SIMULATED_NOTE}")
    two, one = paper_tex(told, 2), paper_tex(told, 1)
    assert [two.count(rf"\input{{table{n}}}") for n in (1, 2, 3)] == [1, 1, 1]
    assert re.findall(r"\\includegraphics.*\{(\w+)\}", two) == ["foundation_effect", "comparison"]
    assert re.findall(r"\\includegraphics.*\{(\w+)\}", one) == ["comparison"]
    assert all(r"\renewenvironment{table}" in each for each in (one, two))  # no table alone in a column
    assert [re.search(r"setcounter\{figure\}\{(\d)", each)[1] for each in (two, one)] == ["1", "2"]
    assert r"\textbf{Laws (simulated records).} What is drawn.}" in one and SIMULATED_NOTE not in one
    assert r"\textbf{A title.} What" in two


def compiles(folder, package, names, more=""):
    """What LaTeX says of a document of some files, which compiles without a word that it can't set."""
    inputs = "\n".join(rf"\input{{{name}}}" for name in names) + more
    (folder / "all.tex").write_text(
        rf"\documentclass[twocolumn]{{article}}\usepackage{{{package}}}\begin{{document}}{inputs}\end{{document}}"
    )
    done = subprocess.run(
        ["pdflatex", "-halt-on-error", "-interaction=nonstopmode", "all.tex"],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout[-2000:]
    assert "Missing character" not in done.stdout
    return done.stdout
