"""Parsers of texts into SDC trees. Each can be a row of Table 3.

A parser is a function from a text to its top-level clauses, or to a
:class:`~g3.language.parsing.extractor.Parse` with several trees. :func:`parser` registers one under
a name, for ``ct eval --table 3 --parser NAME`` and ``--sdc --parser NAME``. Modules that other
distributions name in the entry point group ``ct.parsers`` register theirs when this one is
imported.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from g3.language.parsing.extractor import Parse, Tree
from g3.registry import Registry, blaming
from g3.sdc.clauses import SDC
from g3.short_repr import short_repr

ParseFunction = Callable[[str], "Sequence[SDC] | Parse"]


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class RegisteredParser:
    """A function that is registered as a parser."""

    name: str
    description: str
    function: ParseFunction

    def parse(self, text: str) -> Parse:
        """Parse a text into its trees.

        Raises
        ------
        CorpusError
            If the function raises anything.
        """
        with blaming(f"the parser {self.name}", f"command {text!r}"):
            found = self.function(text)
            trees = (Tree(tuple(found), 1.0),) if not isinstance(found, Parse) and found else ()
            return found if isinstance(found, Parse) else Parse(text, trees)


PARSERS: Registry[RegisteredParser] = Registry("parser", "ct.parsers")


def parser(name: str) -> Callable[[ParseFunction], ParseFunction]:
    """Register a function as a parser.

    Raises
    ------
    ValueError
        If another parser has the name.
    """
    return PARSERS.adding(name, partial(RegisteredParser, name))


parser_named = PARSERS.known
"""The parser with a name; a CorpusError if there is none."""

PARSERS.load_others()
