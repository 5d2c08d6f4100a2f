"""Plainness of the prose: long sentences and idioms of pages, docstrings and help texts.

``python docs/prose_report.py [FILE|FOLDER ...]`` prints a row for each page and module. Code,
tables and addresses don't count, but cells of tables that hold a paragraph do. It only reports: its
exit status is always 0.
"""

from __future__ import annotations

import argparse
import ast
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, TypeGuard

ROOT = Path(__file__).resolve().parents[1]
CODE = ("g3", "corpus_tools", "annotation_app", "eval", "benchmarks")
LONGEST = 25
"""Words of a sentence that is still easy to read."""
FULLEST = 45
"""Words of a table's cell that is still easy to read."""
IDIOMS = (
    r"tells?", r"told", r"what it costs", r"for who", r"comes? along", r"whatever", r"as it were",
    r"of whose", r"hold(?:s|ing)? \w+ against", r"whoever", r"besides", r"anew", r"all else",
    r"(?-i:Who) [^?]*[.,]",
)  # fmt: skip
_IDIOM = re.compile(rf"\b(?:{'|'.join(IDIOMS)})(?!\w)", re.IGNORECASE)
_END = re.compile(r"(?<=[.!?:;])\s+(?=[A-Z`*(\[-])|\n\s*\n|\n\s*(?:[-*]|\d+\.)\s")


class Prose(NamedTuple):
    """Counts of a text."""

    name: str
    sentences: list[str]
    idioms: Counter[str]
    full_cells: int

    @property
    def lengths(self) -> list[int]:
        """Words of each sentence."""
        return [len(sentence.split()) for sentence in self.sentences]


def prose_of(name: str, texts: Iterator[str], full_cells: int = 0) -> Prose:
    """Count sentences and idioms."""
    sentences: list[str] = []
    idioms: Counter[str] = Counter()
    for text in texts:
        sentences += [s for part in _END.split(text) if len((s := part.strip()).split()) > 2]
        found = _IDIOM.findall(re.sub("`[^`]*`", "", text))
        idioms.update("Who …" if each.startswith("Who ") else each.lower() for each in found)
    return Prose(name, sentences, idioms, full_cells)


def full_cells(text: str) -> int:
    """Count the cells of a page's tables that hold a paragraph."""
    rows = re.findall(r"^\|.*\|$", text, flags=re.MULTILINE)
    return sum(len(cell.split()) > FULLEST for row in rows for cell in row.split("|"))


def page_text(text: str) -> str:
    """Return a page without code, tables, headings and the addresses of its links."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^\s*[|#!].*$", "\n", text, flags=re.MULTILINE)
    return re.sub(r"\]\([^)]*\)", "]", text)


def code_texts(source: str) -> Iterator[str]:
    """Yield a module's docstrings, without headings of their sections, and its help texts."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and _is_text(node.value):
            text = str(node.value.value)
            text = re.sub(r"^\s*\S.*\n\s*-{3,}\s*$", "\n", text, flags=re.MULTILINE)
            text = re.sub(r"^ *\w[\w, ]*$(?=\n {8})", "\n", text, flags=re.MULTILINE)  # parameters
            yield re.sub(r"\x08.*", "", text, flags=re.DOTALL)
        elif isinstance(node, ast.keyword) and node.arg in ("help", "fix", "short_help"):
            yield from (n.value for n in ast.walk(node) if _is_text(n))


def _is_text(node: ast.AST) -> TypeGuard[ast.Constant]:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def read(path: Path) -> Prose:
    """Count a file's prose."""
    text = path.read_text(encoding="utf-8")
    name = str(path.resolve().relative_to(ROOT))
    if path.suffix == ".py":
        return prose_of(name, code_texts(text))
    return prose_of(name, iter([page_text(text)]), full_cells(text))


def line(name: str, pages: list[Prose]) -> str:
    """Return a row of the report."""
    lengths = [n for page in pages for n in page.lengths]
    idioms = sum((page.idioms for page in pages), Counter[str]())
    often = ", ".join(f"{word} {count}" for word, count in idioms.most_common(4))
    mean = sum(lengths) / max(1, len(lengths))
    long = sum(n > LONGEST for n in lengths)
    cells = sum(page.full_cells for page in pages)
    counts = f"{mean:6.1f} {long:6} {len(lengths):7} {sum(lengths):7} {cells:7} {idioms.total():7}"
    return f"{counts}  {name:50} {often}"


def main() -> None:
    """Print the report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("paths", nargs="*", type=Path, help="files and folders [default: all]")
    parser.add_argument("--long", action="store_true", help="print the long sentences, too")
    parser.add_argument("--folders", action="store_true", help="print sums only")
    given = parser.parse_args()
    paths = given.paths or [ROOT / name for name in ("README.md", "docs", *CODE)]
    print("  mean   long    sent.   words   cells  idioms")
    for path in paths:
        files = [path] if path.is_file() else sorted([*path.rglob("*.md"), *path.rglob("*.py")])
        pages = [page for file in files if (page := read(file)).sentences]
        if len(pages) > 1 and not given.folders:
            print(*(line(page.name, [page]) for page in pages), sep="\n")
        print(line(str(path.resolve().relative_to(ROOT)), pages))
        for page in pages if given.long else ():
            for sentence in page.sentences:
                if len(sentence.split()) > LONGEST:
                    print(f"{page.name}: {' '.join(sentence.split())}")


if __name__ == "__main__":
    main()
