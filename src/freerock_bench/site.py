"""The site: the pages of docs/ and others, the command line and the Python API, by Sphinx.

    python -m freerock_bench.site [FOLDER]            # site/ by default; no warnings, nothing fetched

Pages outside docs/ (README.md, config/README.md, ...) join the site. The command line, the columns, the
Python API, the gallery and the page of each chapter are generated. Links become links of the site.
"""

import inspect
import io
import os
import posixpath
import re
import shutil
import sys
import tempfile
from contextlib import redirect_stdout, suppress
from pathlib import Path
from unittest.mock import patch

import yaml
from sphinx.cmd.build import build_main

import freerock
from freerock.cli.subcommands import COMMANDS, main
from freerock.columns import columns
from freerock.figures.listed import FIGURES, entry_of
from freerock.products.netcdf_groups import VARIABLES
from freerock_bench.document import in_markdown
from freerock_bench.evidence import CITED
from freerock_bench.gallery import program

ROOT = Path(__file__).parents[2]
PAGES = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_bytes())
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")
FENCE = re.compile(r"(^ *```.*?^ *```$)", re.M | re.S)
SHOWN = (".md", ".png", ".svg")  # of docs/; other files stand in the repository alone


def build(folder: str | Path) -> int:
    """Stage all pages in a temporary folder and build the site from them; Sphinx's exit code."""
    with tempfile.TemporaryDirectory() as source:
        stage(Path(source))
        there = ["-D", f"plot_working_directory={ROOT}"]  # of the records that pages read
        return build_main(["-W", "--keep-going", "-q", "-E", "-b", "html", *there, source, str(folder)])


def stage(source: Path) -> None:
    """Write every page and figure of the site, with Sphinx's settings."""
    shutil.copytree(ROOT / "docs/images", source / "images", ignore=shutil.ignore_patterns("*.py", "*.csv"))
    for name in ("conf.py", "site.css"):
        shutil.copy(ROOT / "docs/site" / name, source / name)
    found = [path.relative_to(ROOT).as_posix() for path in sorted((ROOT / "docs").rglob("*.md"))]
    written = {}
    for path, page in ({each: each.removeprefix("docs/") for each in found} | PAGES["outside"]).items():
        written[page] = converted((ROOT / path).read_text(encoding="utf-8"), path, page)
    written |= {"command-line.md": command_line(), "columns.md": columns_page(), **api()}
    written["gallery.md"] = gallery()
    for page, headed in PAGES["chapters"].items():
        for title, names in headed.items():
            written[f"{page}.md"] = chapter(page, title, names.split(), written)
    written["index.md"] += toctree(["Tutorial <tutorial>", *PAGES["top"].split()])
    for page, text in written.items():
        (source / page).parent.mkdir(exist_ok=True)
        (source / page).write_text(text, encoding="utf-8")


def converted(text: str, source: str, page: str) -> str:
    """A page with the links of the site, outside of code; code of languages that Pygments lacks as text."""
    parts = FENCE.split(text)
    parts[::2] = [LINK.sub(lambda found: linked(found, source, page), part) for part in parts[::2]]
    listed = posixpath.relpath("evidence.html", posixpath.dirname(page) or ".")
    parts[::2] = [CITED.sub(rf'<a href="{listed}#\1">\2</a>', part) for part in parts[::2]]
    return re.sub(r"^( *)```csv$", r"\1```text", "".join(parts), flags=re.M)


def linked(found: re.Match[str], source: str, page: str) -> str:
    """A link as the site has it; the plain text where its target is a file of the repository alone."""
    image, text, target = found.groups()
    if re.match(r"[a-z]+:|#", target):
        return found[0]
    path, _, anchor = target.partition("#")
    there = posixpath.normpath(posixpath.join(posixpath.dirname(source), path))
    known = PAGES["outside"] | PAGES["folders"]
    other = known.get(there, there.removeprefix("docs/") if there.startswith("docs/") else "")
    if not other.endswith(SHOWN):
        return text
    relative = posixpath.relpath(other, posixpath.dirname(page) or ".")
    return f"{image}[{text}]({relative}{'#' if anchor else ''}{anchor})"


def chapter(page: str, title: str, names: list[str], written: dict[str, str]) -> str:
    """The page of a chapter: a line for each of its pages."""
    below = posixpath.dirname(page)
    lines = []
    for name in names:
        heading = re.search(r"^# (.*)$", written[posixpath.join(below, f"{name}.md")], re.M)
        assert heading, name
        lines.append(f"- [{heading[1]}]({name}.md)")
    return f"# {title}\n\n" + "\n".join(lines) + "\n" + toctree(names)


def toctree(names: list[str]) -> str:
    """Sphinx's tree of pages, hidden."""
    return "\n\n```{toctree}\n:hidden:\n\n" + "\n".join(names) + "\n```\n"


def command_line() -> str:
    """What `freerock COMMAND --help` prints, of all commands."""
    text = "# Command line\n\nThis page shows the answer of `--help`, command by command.\n"
    for name in ("", *COMMANDS):
        text += f"\n## freerock {name}".rstrip() + f"\n\n```text\n{help_of(*name.split())}```\n"
    return text


def columns_page() -> str:
    """Every variable of the datasets and every column of the tables, with unit and meaning."""
    variables = [[f"`{name}`", each["unit"], each["long_name"]] for name, each in VARIABLES.items()]
    rows = [[f"`{each.name}`", each.unit, each.meaning, ", ".join(sorted(each.files))] for each in columns()]
    return (
        "# Variables and columns\n\n## Variables of the datasets\n\n"
        + in_markdown(["variable", "unit", "meaning"], variables)
        + "\n\n## Columns of the tables\n\n"
        + in_markdown(["column", "unit", "meaning", "tables"], rows)
        + "\n"
    )


def help_of(*words: str) -> str:
    """The help of a command, 96 columns wide."""
    printed = io.StringIO()
    with patch.dict(os.environ, COLUMNS="96"), redirect_stdout(printed), suppress(SystemExit):
        main([*words, "--help"])
    return printed.getvalue()


def api() -> dict[str, str]:
    """A page for each room that has public names, and the list of all."""
    rooms: dict[str, list[str]] = {}
    rows = []
    for name in freerock.__all__:
        found = getattr(freerock, name)
        path, room = f"{found.__module__}.{name}", found.__module__.split(".")[1]
        kind = "class" if inspect.isclass(found) else "function"
        members = "   :members:\n" if kind == "class" else ""
        directive = f"```{{eval-rst}}\n.. auto{kind}:: {path}\n{members}```\n"
        rooms.setdefault("config" if room == "errors" else room, []).append(directive)
        first_line = (inspect.getdoc(found) or "").partition("\n")[0].replace("|", "\\|")
        rows.append(f"| {{py:obj}}`{name} <{path}>` | {first_line} |")
    pages = {f"api/{room}.md": f"# freerock: {room}\n\n" + "\n".join(own) for room, own in rooms.items()}
    pages["api/index.md"] = (
        "# Python API\n\nPublic names of `freerock`. Units are SI. Angles are in radians.\n"
        "Everything else is internal and may change.\n\n| name | what it is |\n|---|---|\n"
        + "\n".join(sorted(rows))
        + "\n"
        + toctree(sorted(rooms))
    )
    return pages


def gallery() -> str:
    """The figures of a report, each with its caption and the Python that draws it."""
    figures = [
        f"## {each['title']}\n\n"
        f"```{{figure}} images/report_{name}.png\n\n{each['caption']}\n```\n\n"
        f"```python\n{program(name)}\n```\n"
        for name, each in ((name, entry_of(name)) for name in FIGURES)
    ]
    return "# Gallery\n\nAll records shown are simulated.\n\n" + "\n".join(figures)


if __name__ == "__main__":
    raise SystemExit(build(sys.argv[1] if len(sys.argv) > 1 else ROOT / "site"))
