"""Sphinx's settings of the site; `python -m freerock_bench.site` stages its pages and calls Sphinx."""

import re
import sys

project = "freerock"
copyright = "freerock's authors"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
extensions += ["matplotlib.sphinxext.plot_directive"]
plot_formats = [("png", 110)]
plot_html_show_formats = plot_html_show_source_link = False
highlight_language = "none"
myst_heading_anchors = 4
myst_links_external_new_tab = False
suppress_warnings = ["autodoc.mocked_object"]
autodoc_typehints = "none"  # docstrings state types, shapes and units
maximum_signature_line_length = 90
autodoc_preserve_defaults = True
autodoc_member_order = "bysource"
napoleon_numpy_docstring = True
napoleon_google_docstring = False
napoleon_use_rtype = False
html_theme = "pydata_sphinx_theme"
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_title = "freerock"
html_last_updated_fmt = None
html_theme_options = {
    "navbar_align": "left",
    "show_prev_next": True,
    "secondary_sidebar_items": {"**": ["page-toc"], "verdicts": []},  # room for its wide table
    "header_links_before_dropdown": 7,
    "footer_start": ["copyright"],
    "footer_end": [],
    "navbar_end": ["theme-switcher"],
}
# pages of no chapter have no list of chapters: room for tables
html_sidebars = {page: [] for page in ("tutorial", "validation", "evidence", "gallery")}
UNDERLINE = re.compile(r"\s*-{3,}\s*$")
CODE = re.compile(r"(``.*?``|`[^`]*`)")


def plain_text(app, what, name, obj, options, lines):
    """Docstrings are plain text with code between backticks: nothing else in them is markup."""
    for number, line in enumerate(lines):
        if UNDERLINE.match(line) or line.lstrip().startswith((">>>", "...")):
            continue
        parts = CODE.split(line)
        parts[::2] = [re.sub(r"([*|\\])", r"\\\1", part) for part in parts[::2]]
        parts[::2] = [re.sub(r"(\w)_(?=\W|$)", r"\1\\_", part) for part in parts[::2]]
        parts[1::2] = [f"``{part.strip('`')}``" for part in parts[1::2]]
        lines[number] = "".join(parts)


def setup(app):
    """Before napoleon, which has priority 500."""
    app.connect("autodoc-process-docstring", plain_text, priority=100)
    sys.setrecursionlimit(5000)
