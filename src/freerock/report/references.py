"""What the methods cite, as BibTeX."""

from collections.abc import Iterable
from typing import NamedTuple


class Reference(NamedTuple):
    """A publication: how a text calls it, and its entry.

    Parameters
    ----------
    short : str
        Authors and year.
    authors, title, journal : str
        As BibTeX takes them; of a guide the journal is its publisher.
    volume, pages : str
    year : int
    doi : str
    """

    short: str
    authors: str
    title: str
    journal: str
    volume: str
    pages: str
    year: int
    doi: str


REFERENCES = {
    "moreau1988": Reference(
        "Moreau 1988",
        "Moreau, Jean Jacques",
        "Unilateral contact and dry friction in finite freedom dynamics",
        "Nonsmooth Mechanics and Applications",
        "302",
        "1--82",
        1988,
        "10.1007/978-3-7091-2624-0_1",
    ),
    "wang1992": Reference(
        "Wang and Mason 1992",
        "Wang, Yu and Mason, Matthew T.",
        "Two-dimensional rigid-body collisions with friction",
        "Journal of Applied Mechanics",
        "59",
        "635--642",
        1992,
        "10.1115/1.2893771",
    ),
    "housner1963": Reference(
        "Housner 1963",
        "Housner, George W.",
        "The behavior of inverted pendulum structures during earthquakes",
        "Bulletin of the Seismological Society of America",
        "53",
        "403--417",
        1963,
        "10.1785/BSSA0530020403",
    ),
    "koh1986": Reference(
        "Koh et al. 1986",
        "Koh, Aik-Siong and Spanos, Pol D. and Roesset, Jose M.",
        "Harmonic rocking of rigid block on flexible foundation",
        "Journal of Engineering Mechanics",
        "112",
        "1165--1180",
        1986,
        "10.1061/(ASCE)0733-9399(1986)112:11(1165)",
    ),
    "hunt1975": Reference(
        "Hunt and Crossley 1975",
        "Hunt, K. H. and Crossley, F. R. E.",
        "Coefficient of restitution interpreted as damping in vibroimpact",
        "Journal of Applied Mechanics",
        "42",
        "440--445",
        1975,
        "10.1115/1.3423596",
    ),
    "bandis1983": Reference(
        "Bandis et al. 1983",
        "Bandis, S. C. and Lumsden, A. C. and Barton, N. R.",
        "Fundamentals of rock joint deformation",
        "International Journal of Rock Mechanics and Mining Sciences and Geomechanics Abstracts",
        "20",
        "249--268",
        1983,
        "10.1016/0148-9062(83)90595-8",
    ),
    "spanos2017": Reference(
        "Spanos et al. 2017",
        "Spanos, Pol D. and Di Matteo, Alberto and Pirrotta, Antonina and Di Paola, Mario",
        "Nonlinear rocking of rigid blocks on flexible foundation: analysis and experiments",
        "Procedia Engineering",
        "199",
        "284--289",
        2017,
        "10.1016/j.proeng.2017.09.024",
    ),
    "schwarz1978": Reference(
        "Schwarz 1978",
        "Schwarz, Gideon",
        "Estimating the dimension of a model",
        "The Annals of Statistics",
        "6",
        "461--464",
        1978,
        "10.1214/aos/1176344136",
    ),
    "riedel1995": Reference(
        "Riedel and Sidorenko 1995",
        "Riedel, Kurt S. and Sidorenko, Alexander",
        "Minimum bias multiple taper spectral estimation",
        "IEEE Transactions on Signal Processing",
        "43",
        "188--195",
        1995,
        "10.1109/78.365298",
    ),
    "paule1982": Reference(
        "Paule and Mandel 1982",
        "Paule, Robert C. and Mandel, John",
        "Consensus values and weighting factors",
        "Journal of Research of the National Bureau of Standards",
        "87",
        "377--385",
        1982,
        "10.6028/jres.087.022",
    ),
    "coombs1996": Reference(
        "Coombs and Algina 1996",
        "Coombs, William T. and Algina, James",
        "New test statistics for {MANOVA}/descriptive discriminant analysis",
        "Educational and Psychological Measurement",
        "56",
        "382--402",
        1996,
        "10.1177/0013164496056003002",
    ),
    "krishnamoorthy2004": Reference(
        "Krishnamoorthy and Yu 2004",
        "Krishnamoorthy, Kalimuthu and Yu, Jianqi",
        "Modified {Nel} and {Van der Merwe} test for the multivariate {Behrens--Fisher} problem",
        "Statistics and Probability Letters",
        "66",
        "161--169",
        2004,
        "10.1016/j.spl.2003.10.012",
    ),
    "hartung2001": Reference(
        "Hartung and Knapp 2001",
        "Hartung, Joachim and Knapp, Guido",
        "On tests of the overall treatment effect in meta-analysis with normally distributed responses",
        "Statistics in Medicine",
        "20",
        "1771--1782",
        2001,
        "10.1002/sim.791",
    ),
    "jcgm2008": Reference(
        "JCGM 100:2008",
        "{Joint Committee for Guides in Metrology}",
        "Evaluation of measurement data: guide to the expression of uncertainty in measurement",
        "JCGM",
        "100",
        "",
        2008,
        "10.59161/JCGM100-2008E",
    ),
    "virtanen2020": Reference(
        "Virtanen et al. 2020",
        "Virtanen, Pauli and others",
        "{SciPy} 1.0: fundamental algorithms for scientific computing in {Python}",
        "Nature Methods",
        "17",
        "261--272",
        2020,
        "10.1038/s41592-019-0686-2",
    ),
    "molder2021": Reference(
        "Mölder et al. 2021",
        'M{\\"o}lder, Felix and others',
        "Sustainable data analysis with {Snakemake}",
        "F1000Research",
        "10",
        "33",
        2021,
        "10.12688/f1000research.29032.2",
    ),
}


def bibtex(keys: Iterable[str]) -> str:
    """The entries of some references.

    Parameters
    ----------
    keys : iterable of str
        Of `REFERENCES`.
    """
    return "\n".join(_entry(key, REFERENCES[key]) for key in keys)


def _entry(key: str, known: Reference) -> str:
    fields = {
        "author": known.authors,
        "title": known.title,
        "journal": known.journal,
        "volume": known.volume,
        "pages": known.pages,
        "year": str(known.year),
        "doi": known.doi,
    }
    lines = [f"  {name} = {{{text}}}," for name, text in fields.items() if text]
    return "\n".join([f"@article{{{key},", *lines, "}", ""])
