"""The effect of each rewriting of clauses: ``python -m benchmarks.rewriting_off``.

A command is won by a function of :mod:`g3.inference.problem.plain_clauses` if its plan is right
with it and wrong without it, and lost the other way round. Commands that no function changes are
followed once.
"""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from scipy.stats import binomtest

from benchmarks.written_commands import (
    SETS,
    by_model,
    followed,
    learned_cost,
    parser_of,
    records_of,
)
from g3.inference.grounder import Grounder
from g3.inference.problem import plain_clauses
from g3.inference.tree_choice import PARSES
from g3.language.parsing.parser import parse_unsure

FUNCTIONS = (
    *("restored", "_shared", "_one_place", "_one_deck", "measures_apart", "_light"),
    *("_filled", "_needed", "_result", "without_statements", "repeated"),
)


@contextmanager
def watched(off: str = "") -> Iterator[set[str]]:
    """Collect the functions that change a clause; `off` is left out."""
    changed: set[str] = set()
    usual = {name: getattr(plain_clauses, name) for name in FUNCTIONS}

    def instead(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(function)
        def watching(given: Any, *others: Any) -> Any:
            if name == off:
                return given
            result = function(given, *others)
            if result is not None and _comparable(result) != _comparable(given):
                changed.add(name)
            return result

        return watching

    try:
        for name, function in usual.items():
            setattr(plain_clauses, name, instead(name, function))
        yield changed
    finally:
        for name, function in usual.items():
            setattr(plain_clauses, name, function)


def _comparable(value: Any) -> Any:
    return tuple(value) if isinstance(value, (list, tuple)) else value


def main() -> None:
    options = parser_of("rewriting_off", __doc__).parse_args()
    grounder = Grounder(learned_cost(options.train.split(",")))
    spoke, won, lost = Counter[str](), Counter[str](), Counter[str]()
    for name in options.sets or SETS:
        for record in records_of(name):
            plan = by_model(grounder, parse_unsure(record["text"], n_best=PARSES))
            with watched() as changed:
                right = followed(record, plan).correct
            for function in sorted(changed):
                with watched(function):
                    without = followed(record, plan).correct
                spoke[function] += 1
                won[function] += right and not without
                lost[function] += without and not right
    for name in FUNCTIONS:
        p = binomtest(won[name], won[name] + lost[name]).pvalue if won[name] + lost[name] else 1.0
        print(
            f"{name.strip('_'):20} changed {spoke[name]:4}  {won[name]:3} won, {lost[name]:3} lost"
            f"  sign test {p:.3f}"
        )


if __name__ == "__main__":
    main()
