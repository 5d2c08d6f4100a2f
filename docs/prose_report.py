"""Check the prose of pages, docstrings and help texts.

``python docs/prose_report.py [FILE|FOLDER ...]`` prints a line for each idiom, with a plainer
phrase, and for each page whose sentences are long. It exits with 1 where it printed any.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, TypeGuard

ROOT = Path(__file__).resolve().parents[1]
CHECKED = (
    "README.md", "CONTRIBUTING.md", "docs", "examples", "datasets", "benchmarks",
    "g3", "corpus_tools", "annotation_app", "eval", "ct",
)  # fmt: skip
TO_BE_REBUILT = ("g3/language", "g3/inference/problem", "g3/inference/potentials")
"""Folders that are not checked yet."""
LONGEST_MEAN = 18
"""Words of a page's mean sentence."""
FEWEST = 5
"""Sentences from which on a page has a mean."""
IDIOMS = {
    r"the ones? (?:that|which|who|whose|of|with|in|for|by|to)": "the noun itself",
    r"(?:says?|said) so": "a message says which, is listed, is reported",
    r"told|tells?(?! apart)": "reported, stated, shown",
    r"deeds?": "execution, action",
    r"mend(?:s|ed|ing)?": "fix, repair",
    r"on trial": "under evaluation",
    r"unread(?! data)": "held-out",
    r"(?:go|goes|went|gone|going) on(?= (?:\w+ing|as|with|where|until|after|when)\b|[.,;:])": (
        "continue"
    ),
    r"comes? along": "ships, is included",
    r"for who(?:m|ever)?": "people who",
    r"of whose": "whose",
    r"(?:whoever|whatever)": "people who, any",
    r"besides": "also, beside",
    r"anew": "again",
    r"all else": "everything else, the rest",
    r"as it were": "(leave it out)",
    r"what it costs": "the cost",
    r"hold(?:s|ing)? \w+ against": "compare with",
}
"""Patterns of idioms, with what to write instead."""
_IDIOM = re.compile(
    "|".join(rf"(?P<i{n}>\b(?:{pattern})(?!\w))" for n, pattern in enumerate(IDIOMS)),
    re.IGNORECASE,
)
_BETTER = list(IDIOMS.values())
_WHO = re.compile(r"(?:^|(?<=[.!] ))(?:Who|Whoever)\b[^?.]*[.]", re.MULTILINE)
_OPENING = re.compile(r"\s*(What|Whether|Who)\b")
_SENTENCE_END = re.compile(r"(?<=[.!?:;])\s+(?=[A-Z`*(\[-])|\n\s*\n|\n\s*(?:[-*]|\d+\.)\s")
_NO_PROSE = re.compile(r"^```.*?^```|`[^`\n]*`|\"[^\"\n]*\"", re.DOTALL | re.MULTILINE)


class Finding(NamedTuple):
    """A phrase to replace."""

    line: int
    phrase: str
    better: str


def idioms_in(text: str, first_line: int = 1) -> Iterator[Finding]:
    """Yield the idioms of a text, outside code and quotations."""
    prose = _NO_PROSE.sub(lambda match: re.sub(r"[^\n]", "~", match[0]), text)
    for match in _IDIOM.finditer(prose):
        better = _BETTER[int((match.lastgroup or "i0")[1:])]
        yield Finding(_line(prose, match.start(), first_line), match[0], better)
    for match in _WHO.finditer(prose):
        yield Finding(_line(prose, match.start(), first_line), "Who …", "People who …")


def _line(text: str, position: int, first_line: int) -> int:
    return first_line + text.count("\n", 0, position)


def mean_sentence(page: str) -> float:
    """Return the mean words of a page's sentences, without code, tables and headings."""
    text = re.sub(r"^```.*?^```", "", page, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^\s*[|#!].*$", "\n", text, flags=re.MULTILINE)
    text = re.sub(r"\]\([^)]*\)", "]", text)
    lengths = [len(sentence.split()) for sentence in _SENTENCE_END.split(text)]
    sentences = [length for length in lengths if length > 2]
    return sum(sentences) / len(sentences) if len(sentences) >= FEWEST else 0


def check_page(text: str) -> Iterator[Finding]:
    """Yield the idioms of a Markdown page, and its mean sentence where that is long."""
    yield from idioms_in(text)
    if (mean := mean_sentence(text)) > LONGEST_MEAN:
        yield Finding(1, f"{mean:.1f} words a sentence", f"at most {LONGEST_MEAN}")


def check_module(source: str) -> Iterator[Finding]:
    """Yield the idioms of docstrings and help texts, and docstrings that begin as questions."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and _is_text(node.value):
            yield from idioms_in(str(node.value.value), node.lineno)
            if match := _OPENING.match(str(node.value.value)):
                yield Finding(node.lineno, f"{match[1]} …", "a verb or a noun first")
        elif isinstance(node, ast.keyword) and node.arg in ("help", "fix", "short_help"):
            for text in filter(_is_text, ast.walk(node)):
                yield from idioms_in(str(text.value), text.lineno)


def _is_text(node: ast.AST) -> TypeGuard[ast.Constant]:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def check(path: Path) -> list[Finding]:
    """Return the findings in a file."""
    text = path.read_text(encoding="utf-8")
    return sorted(check_module(text) if path.suffix == ".py" else check_page(text))


def files_of(path: Path) -> list[Path]:
    """Return the pages and modules of a folder, or the file itself."""
    if path.is_file():
        return [path]
    rebuilt = [ROOT / name for name in TO_BE_REBUILT]
    files = sorted([*path.rglob("*.md"), *path.rglob("*.py")])
    return [f for f in files if not any(f.resolve().is_relative_to(r) for r in rebuilt)]


def main() -> None:
    """Print the findings."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("paths", nargs="*", type=Path, help="files and folders [default: all]")
    paths = parser.parse_args().paths or [ROOT / name for name in CHECKED]
    count = 0
    for file in (file for path in paths for file in files_of(path)):
        for finding in check(file):
            count += 1
            name = file.resolve()
            shown = name.relative_to(ROOT) if name.is_relative_to(ROOT) else name
            print(f'{shown}:{finding.line}: "{finding.phrase}": {finding.better}')
    sys.exit(min(count, 1))


if __name__ == "__main__":
    main()
