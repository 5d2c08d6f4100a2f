"""Hand-written trees that the bundled parser is trained on besides the treebank.

They hold what people say and corpora of commands seldom have: "all the tires", "never", "without
touching it". None is from a corpus.
"""

from __future__ import annotations

from importlib import resources

from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import parse_brackets

FILE = "lessons.txt"


def written_text() -> str:
    """The file of hand-written trees."""
    return (resources.files("g3.language.parsing.training") / FILE).read_text("utf-8")


def written_trees() -> list[tuple[str, tuple[SDC, ...]]]:
    """The commands with their top-level clauses."""
    found = []
    for paragraph in written_text().split("\n\n"):
        if not paragraph.startswith("#"):
            text, *notation = paragraph.strip().splitlines()
            found.append((text, parse_brackets("\n".join(notation), command=text)))
    return found
