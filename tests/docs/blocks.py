"""The commands that the documentation shows."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

_FENCE = re.compile(r"^```(\w*)[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)
_SHELL = {"sh", "console", ""}


@dataclass(frozen=True)
class Shown:
    """A command as a page shows it.

    Parameters
    ----------
    page
        From the root of the repository.
    line
        Where the block begins.
    text
        The command, on one line and without its comment.
    output
        What the page shows of its output; None where it shows none.
    """

    page: str
    line: int
    text: str
    output: str | None = None

    @property
    def calls(self) -> list[list[str]]:
        """The arguments of each call of ``ct`` in it."""
        text = re.sub(r"\$\([^)]*\)", "SOMETHING", self.text)
        lexer = shlex.shlex(text, posix=True, punctuation_chars="&|<>")
        lexer.whitespace_split, lexer.commenters = True, ""
        calls: list[list[str]] = [[]]
        for word in lexer:
            if set(word) <= set("&|"):
                calls.append([])
            elif calls[-1] or "=" not in word:  # not what sets a variable
                calls[-1].append(word)
        named = [c for c in calls if c and c[0].rpartition("/")[2] == "ct"]
        return [_without_redirections(c[1:]) for c in named]


def _without_redirections(words: list[str]) -> list[str]:
    end = next((i for i, word in enumerate(words) if set(word) <= set("<>")), len(words))
    return words[:end]


def pages() -> list[Path]:
    """The pages of the documentation."""
    folders = [*ROOT.glob("docs/**/*.md"), *ROOT.glob("examples/**/*.md")]
    others = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *ROOT.glob("datasets/**/README.md")]
    return sorted([*others, *folders])


def shown() -> list[Shown]:
    """Every command that a page shows, in order."""
    found: list[Shown] = []
    for page in pages():
        content = page.read_text()
        for match in _FENCE.finditer(content):
            language, block = match.groups()
            if language not in _SHELL:
                continue
            line = content.count("\n", 0, match.start()) + 1
            name = page.relative_to(ROOT).as_posix()
            if "\n$ " in f"\n{block}":
                found += _session(name, line, block)
            elif language == "sh" or block.lstrip().startswith(("ct ", "pip ")):
                found += [Shown(name, line, text) for text in _lines(block)]
    return found


def _session(page: str, line: int, block: str) -> list[Shown]:
    parts = re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]
    found = []
    for part in parts:
        command, _, output = part.partition("\n")
        found.append(Shown(page, line, command, output or None))
    return found


def _lines(block: str) -> list[str]:
    joined = re.sub(r"\s*\\\n\s*", " ", block)
    lines = (_without_comment(line) for line in joined.splitlines())
    return [line for line in lines if line]


def _without_comment(line: str) -> str:
    lexer = shlex.shlex(line, posix=False, punctuation_chars=False)
    lexer.whitespace_split = True
    lexer.commenters = "#"
    return " ".join(lexer)


_FIGURE = re.compile(r"all alike|\d[\d.]*(?:-\d[\d.]*)?")
_RULE = re.compile(r"[-+]{4,}")


def alike(shown: str, printed: str) -> bool:
    """Check that a page shows what is printed, but for figures; "..." is anything."""
    parts = (re.escape(_words(part)) for part in shown.split("..."))
    return bool(re.search(".*".join(parts), _words(printed)))


def _words(text: str) -> str:
    """Return the words of a text, without its rules and with "#" for each figure."""
    return " ".join(_RULE.sub("", _FIGURE.sub("#", text)).split())
