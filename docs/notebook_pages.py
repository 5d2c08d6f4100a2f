"""Notebooks of the documentation: MyST Markdown with code cells, which run anywhere.

They are text, so that a change of one can be read. JupyterLab opens them with jupytext; the site
has each as an ``.ipynb`` too. The tests and the site run them here, without a kernel.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

FRONT_MATTER = re.compile(r"\A---\n.*?\n---\n", re.DOTALL)
CELL = re.compile(r"^```{code-cell}[^\n]*\n(.*?)^```$\n?", re.MULTILINE | re.DOTALL)
KERNEL = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}


@dataclass(frozen=True)
class Cell:
    """A part of a notebook."""

    kind: Literal["markdown", "code"]
    source: str


@dataclass(frozen=True)
class Output:
    """Printed text of a code cell, and the display of its last line in a notebook."""

    printed: str = ""
    html: str = ""


def cells(text: str) -> list[Cell]:
    """Return the cells of a notebook, in order."""
    parts = CELL.split(FRONT_MATTER.sub("", text))
    kinds: tuple[Literal["markdown", "code"], ...] = ("markdown", "code")
    found = (Cell(kinds[n % 2], part.strip("\n")) for n, part in enumerate(parts))
    return [cell for cell in found if cell.source]


def run(notebook: list[Cell]) -> Iterator[Output]:
    """Run the code cells one after the other in the working folder."""
    names: dict[str, Any] = {"__name__": "__main__"}
    for number, cell in enumerate(c for c in notebook if c.kind == "code"):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            value = _value(_without_shell(cell.source), names, f"<cell {number + 1}>")
        html = value._repr_html_() if hasattr(value, "_repr_html_") else ""
        if value is not None and not html:
            printed.write(f"{value!r}\n")
        yield Output(printed.getvalue(), html)


def _without_shell(source: str) -> str:
    """Replace lines of ``!ct`` by Python that calls the command line of this environment."""
    return re.sub(r"^!ct (.*)$", lambda m: f"_ct({m[1]!r})", source, flags=re.MULTILINE)


def _ct(line: str) -> None:
    command = [sys.executable, "-m", "corpus_tools", *shlex.split(line)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    sys.stdout.write(done.stdout)
    if done.returncode:
        raise RuntimeError(f"ct {line}: {done.stderr}")


def _value(source: str, names: dict[str, Any], where: str) -> Any:
    """Run a cell; give the value of its last line if that is an expression."""
    names["_ct"] = _ct
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, where, "exec"), names)  # noqa: S102 - our own notebooks
    if last is None:
        return None
    return eval(compile(ast.Expression(last.value), where, "eval"), names)  # noqa: S307


def page(text: str) -> str:
    """Run a notebook in an empty folder; return it as a page with its outputs."""
    notebook = cells(text)
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        outputs = run(notebook)
        parts = [_shown(next(outputs), c) if c.kind == "code" else c.source for c in notebook]
    return "\n\n".join(parts)


def _shown(output: Output, cell: Cell) -> str:
    language = "text" if cell.source.startswith("!") else "python"
    blocks = [f"```{language}\n{cell.source}\n```"]
    if output.printed:
        blocks.append(f"```text\n{output.printed.rstrip()}\n```")
    if output.html:
        html = "\n".join(line for line in output.html.splitlines() if line.strip())
        blocks.append(f'````{{raw}} html\n<div class="cell-output">{html}</div>\n````')
    return "\n\n".join(blocks)


def to_ipynb(text: str) -> str:
    """Return a notebook in Jupyter's format (nbformat 4.5), without outputs."""
    made = []
    for number, cell in enumerate(cells(text)):
        one: dict[str, Any] = {
            "cell_type": cell.kind,
            "id": f"cell-{number}",
            "metadata": {},
            "source": cell.source.splitlines(keepends=True),
        }
        if cell.kind == "code":
            one |= {"execution_count": None, "outputs": []}
        made.append(one)
    content = {"cells": made, "metadata": KERNEL, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    sys.stdout.write(page(Path(sys.argv[1]).read_text(encoding="utf-8")))
