"""Parsers of texts into SDC trees. Each can be a row of Table 3.

A parser is a function from a text to its top-level clauses, or to a
:class:`~g3.language.parsing.trees.Parse` with several trees. :func:`parser` registers one under
a name, for ``ct eval table3 --parser NAME`` and ``ct eval sdc --parser NAME``. Modules that other
distributions name in the entry point group ``ct.parsers`` register theirs when this one is
imported. A parser that needs more than a function implements :class:`TextParser`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, Protocol

from corpus_tools.corpus.annotated_trees import Annotated
from corpus_tools.runtime.progress import OnProgress
from g3.language.parsing.trees import Parse, Tree
from g3.registry import Registry, blaming
from g3.sdc.clauses import SDC
from g3.short_repr import short_repr

ParseFunction = Callable[..., "Sequence[SDC] | Parse"]
"""A function from a text, and a learned value if the parser learns, to clauses."""
Fit = Callable[[Sequence[Annotated]], Any]
"""A function from commands with their trees, none of them tested, to a learned value."""


class ParseTask(NamedTuple):
    """A text to parse, and what the parser has learned from commands that aren't tested."""

    text: str
    learned: Any = None


class TextParser(Protocol):
    """A parser of texts; processes exchange parsers, which can be pickled and hashed.

    By default a parser has no settings, needs no preparation and doesn't learn.
    """

    @property
    def name(self) -> str:
        """Name of its row."""

    @property
    def about(self) -> Mapping[str, object]:
        """Settings that decide its trees, for readers of the table."""
        return {}

    @property
    def learns(self) -> bool:
        """True if it learns from commands with trees."""
        return False

    def prepare(self, tasks: Sequence[ParseTask], on_progress: OnProgress) -> None:
        """Get ready for all texts at once, before they come one by one."""

    def fit(self, commands: Sequence[Annotated]) -> Any:
        """Learn."""
        return None

    def parse(self, text: str, learned: Any = None) -> Parse:
        """Parse a text into its trees."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class RegisteredParser:
    """A function that is registered as a parser; the parameters are those of :func:`parser`."""

    name: str
    description: str
    function: ParseFunction
    fitting: Fit | None = None

    def __reduce__(self) -> tuple[Callable[[str], RegisteredParser], tuple[str]]:
        return parser_named, (self.name,)

    @property
    def about(self) -> Mapping[str, object]:
        """Nothing: its distribution describes it."""
        return {}

    @property
    def learns(self) -> bool:
        """True if it learns from commands with trees."""
        return self.fitting is not None

    def prepare(self, tasks: Sequence[ParseTask], on_progress: OnProgress) -> None:
        """Do nothing: a function takes one text after the other."""

    def fit(self, commands: Sequence[Annotated]) -> Any:
        """Learn."""
        with blaming(f"the parser {self.name}", "learning"):
            return None if self.fitting is None else self.fitting(commands)

    def parse(self, text: str, learned: Any = None) -> Parse:
        """Parse a text into its trees."""
        with blaming(f"the parser {self.name}", f"command {text!r}"):
            result = self.function(text, learned) if self.learns else self.function(text)
            trees = (Tree(tuple(result), 1.0),) if not isinstance(result, Parse) and result else ()
            return result if isinstance(result, Parse) else Parse(text, trees)


PARSERS: Registry[RegisteredParser] = Registry("parser", "ct.parsers")


def parser(name: str, *, fit: Fit | None = None) -> Callable[[ParseFunction], ParseFunction]:
    """Register a function as a parser.

    Parameters
    ----------
    name
        Name of its row in Table 3.
    fit
        Function to learn with. Its result is the parser function's second argument.

    Raises
    ------
    ValueError
        If another parser has the name.
    """
    return PARSERS.adding(name, partial(RegisteredParser, name, fitting=fit))


def parser_named(name: str) -> RegisteredParser:
    """Return the parser with a name."""
    return PARSERS.known(name)


PARSERS.load_others()
