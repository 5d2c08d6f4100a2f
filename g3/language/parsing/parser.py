"""Commands to SDC trees with the bundled extractor, or another one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from g3.errors import CorpusError
from g3.language.parsing.extractor import Parse, SDCExtractor, default_extractor


def parse(text: str, *, n_best: int = 1, extractor: SDCExtractor | None = None) -> Parse:
    """Extract the SDC trees of a command (section 3.1).

    Parameters
    ----------
    text
        The command, as typed.
    n_best
        How many trees to give, at most.
    extractor
        What to extract with; the bundled one if left out.

    Returns
    -------
    Parse
        The trees with their probabilities, best first, or why there are none.
    """
    return next(parse_many([text], n_best=n_best, extractor=extractor))


def parse_many(
    texts: Iterable[str], *, n_best: int = 1, extractor: SDCExtractor | None = None
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
    return (extractor or default_extractor()).predict_proba(texts, n_best=n_best)
