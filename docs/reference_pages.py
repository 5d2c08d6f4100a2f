"""Write the pages of the site's reference: one for each command, and one for each module."""

from __future__ import annotations

import importlib.metadata
import re
from pathlib import Path

from corpus_tools.runtime.extras import DISTRIBUTION

_MODULES = re.compile(r"^```\{modules\}\n(.*?)\n```$", re.MULTILINE | re.DOTALL)


def with_contents(text: str) -> str:
    """Replace each block of ``modules`` by the contents of their pages."""

    def contents(block: re.Match[str]) -> str:
        pages = (f"modules/{module}" for module, _ in _listed(block[1]))
        return "\n".join(["```{toctree}", ":maxdepth: 1", "", *pages, "```"])

    return _MODULES.sub(contents, text)


def write(folder: Path) -> None:
    """Write ``commands/NAME.rst`` and ``modules/NAME.rst`` into the reference's folder."""
    points = importlib.metadata.distribution(DISTRIBUTION).entry_points
    commands = {"help": "corpus_tools.cli.console:help_"}
    commands |= {point.name: point.value for point in points.select(group="ct.commands")}
    for name, place in commands.items():
        text = f".. click:: {place}\n   :prog: ct {name}\n   :nested: full\n"
        _write(folder / f"commands/{name}.rst", text)
    for block in _MODULES.findall((folder / "python.md").read_text(encoding="utf-8")):
        for module, excluded in _listed(block):
            options = ":members:" + "".join(f"\n   :exclude-members: {name}" for name in excluded)
            title = f"{module}\n{'=' * len(module)}\n\n"
            _write(
                folder / f"modules/{module}.rst",
                f"{title}.. automodule:: {module}\n   {options}\n",
            )


def _listed(block: str) -> list[tuple[str, list[str]]]:
    """Return the modules of a block, and names in them that their pages leave out."""
    lines = (line.split(" without ") for line in block.split("\n"))
    return [(module, excluded) for module, *excluded in lines]


def _write(file: Path, text: str) -> None:
    """Write a page, unless it is there: pages that stay aren't built again."""
    file.parent.mkdir(parents=True, exist_ok=True)
    if not file.exists() or file.read_text(encoding="utf-8") != text:
        file.write_text(text, encoding="utf-8")
