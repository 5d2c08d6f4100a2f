"""The documentation's site: ``sphinx-build -W docs build/docs``."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import click
from sphinx.application import Sphinx

from corpus_tools import __version__
from g3.graph.graph_drawing import to_svg
from g3.graph.grounding_graph import grounding_graph
from g3.sdc.sdc_notation import parse_brackets

sys.path.insert(0, str(Path(__file__).resolve().parent))
import notebook_pages
import reference_pages

project = "corpus-tools-g3"
author = "The corpus-tools authors"
release = version = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_click"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["conf.py"]

html_theme = "furo"
html_title = f"corpus-tools-g3 {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
smartquotes = False
html_show_copyright = False
html_show_sphinx = False
html_search_scorer = str(Path(__file__).resolve().with_name("search_order.js"))

myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_preprocess_types = False

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
COPIES = {
    "readme": "README.md",
    "contributing": "CONTRIBUTING.md",
    "changelog": "CHANGELOG.md",
    "contributing/benchmarks": "benchmarks/README.md",
    "examples": "examples/README.md",
    "data-cards": "datasets/README.md",
}
"""Pages that show a file of the repository, which stands there for those who read it there."""

PARTS = {
    "examples": sorted((ROOT / "examples").glob("*/README.md")),
    "data-cards": sorted((ROOT / "datasets").glob("*/README.md")),
}
"""Files that a page shows after its own."""

_LINK = re.compile(r"(\]\()([^)#\s:]+)(?=[)#])")

FIGURES = {
    "figure-2b": (
        "EVENT(r = Put, l = OBJ(f = the pallet), l2 = PLACE(r = on, l = OBJ(f = the truck)))"
    ),
    "figure-3b": (
        "EVENT(r = Go, l = PATH(r = to,"
        " l = OBJ(f = OBJ(f = the pallet), r = on, l = OBJ(f = the truck))))"
    ),
}
"""Figures of the paper, drawn from the clauses of its Figures 2a and 3a."""


def draw_figures() -> None:
    """Draw the grounding graphs of the paper's figures, as ``ct graph --format svg`` does."""
    folder = DOCS / "_made"
    folder.mkdir(exist_ok=True)
    for name, notation in FIGURES.items():
        drawing = to_svg(grounding_graph(parse_brackets(notation)))
        (folder / f"{name}.svg").write_text(drawing, encoding="utf-8")


def read_copy(app: Sphinx, page: str, source: list[str]) -> None:
    """Read the files that a page shows, and have links between files lead to pages."""
    file = ROOT / COPIES[page] if page in COPIES else DOCS / f"{page}.md"
    files = [file, *PARTS.get(page, ())]
    texts = source if page not in COPIES else [f.read_text(encoding="utf-8") for f in files]
    if page in COPIES:
        for shown in files:
            app.env.note_dependency(str(shown))
    led = [
        _led(text, shown.parent, (DOCS / page).parent)
        for text, shown in zip(texts, files, strict=True)
    ]
    source[0] = "\n".join(
        [led[0], *(re.sub("^#", "##", part, flags=re.MULTILINE) for part in led[1:])]
    )


def _led(text: str, folder: Path, here: Path) -> str:
    """Have links of a file lead to pages, where pages show what they lead to."""
    shown = {(ROOT / name).resolve(): DOCS / f"{copy}.md" for copy, name in COPIES.items()}
    shown |= {
        part.resolve(): DOCS / f"{page}.md" for page, parts in PARTS.items() for part in parts
    }

    def led(match: re.Match[str]) -> str:
        target = (folder / match[2]).resolve()
        if not target.exists():  # made by the build, or for Sphinx to complain about
            return match[0]
        return match[1] + os.path.relpath(shown.get(target, target), here)

    return _LINK.sub(led, text)


def list_modules(_app: Sphinx, _page: str, source: list[str]) -> None:
    """Have each block of ``modules`` lead to their pages."""
    source[0] = reference_pages.with_contents(source[0])


def run_notebook(_app: Sphinx, page: str, source: list[str]) -> None:
    """Run a notebook's cells for its page, and offer it in Jupyter's format."""
    if not page.startswith("notebooks/"):
        return
    folder = DOCS / "_made"
    folder.mkdir(exist_ok=True)
    name = f"{Path(page).name}.ipynb"
    (folder / name).write_text(notebook_pages.to_ipynb(source[0]), encoding="utf-8")
    download = f"{{download}}`As a Jupyter notebook <../_made/{name}>`"
    command = [sys.executable, notebook_pages.__file__, str(DOCS / f"{page}.md")]
    shown = subprocess.run(command, capture_output=True, text=True, check=True).stdout  # noqa: S603
    source[0] = f"{shown}\n\n{download}\n"


def show_examples(_app: Sphinx, _command: click.Context, lines: list[str]) -> None:
    """Set the examples of a command's help as what they are: lines of a shell."""
    shown = []
    for line in lines:
        if line.startswith("| Example"):
            shown += [line[2:], "", ".. code-block:: shell", ""]
        else:
            shown.append(f"    {line[2:].strip()}" if line.startswith("| ") else line)
    lines[:] = shown


def setup(app: Sphinx) -> None:
    """Connect what is done while the site is built."""
    draw_figures()
    reference_pages.write(DOCS / "reference")
    app.connect("source-read", read_copy)
    app.connect("source-read", list_modules)
    app.connect("source-read", run_notebook)
    for part in ("description", "epilog"):
        app.connect(f"sphinx-click-process-{part}", show_examples)
