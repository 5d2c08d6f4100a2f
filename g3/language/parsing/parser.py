"""Commands to SDC trees with the bundled parser, or another one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from g3.errors import CorpusError
from g3.language.parsing.sdc_parser import SDCParser, default_parser
from g3.language.parsing.trees import Parse

SURE = 0.9
"""A tree that is so probable is the only one that is looked at."""
LEAST_LIKELY = 0.05
"""Trees that are so much less probable than the best one are not looked at."""


def parse(text: str, *, n_best: int = 1, extractor: SDCParser | None = None) -> Parse:
    """Extract the SDC trees of a command (section 3.1).

    Parameters
    ----------
    text
        The command, as typed.
    n_best
        How many trees to give, at most.
    extractor
        The parser; the bundled one if left out.

    Returns
    -------
    Parse
        The trees with their probabilities, best first, or why there are none.
    """
    return next(parse_many([text], n_best=n_best, extractor=extractor))


def parse_many(
    texts: Iterable[str], *, n_best: int = 1, extractor: SDCParser | None = None
) -> Iterator[Parse]:
    """Extract the SDC trees of commands; many at once are faster than one after the other.

    Parameters
    ----------
    texts
        Commands.
    n_best, extractor
        As for :func:`parse`.
    """
    if n_best < 1:
        raise CorpusError(f"{n_best} trees were asked for", fix="ask for at least one")
    return (extractor or default_parser()).predict_proba(texts, n_best=n_best)


def parse_unsure(text: str, *, n_best: int, extractor: SDCParser | None = None) -> Parse:
    """Extract the best SDC tree of a command, and others where it isn't sure.

    Parameters
    ----------
    text
        The command, as typed.
    n_best
        How many trees to give, at most. A tree that is `SURE` stays alone, and others are at
        least `LEAST_LIKELY` times as probable as the best.
    extractor
        The parser; the bundled one if left out.
    """
    used = extractor or default_parser()
    (best,) = used.predict_proba([text])
    if n_best == 1 or not best.trees or best.trees[0].probability >= SURE:
        return best
    (several,) = used.predict_proba([text], n_best=n_best)
    least = LEAST_LIKELY * several.trees[0].probability
    return replace(several, trees=tuple(t for t in several.trees if t.probability >= least))
