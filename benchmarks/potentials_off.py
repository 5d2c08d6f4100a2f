"""The effect of each potential: ``python -m benchmarks.potentials_off --out FILE``.

A command is won by a potential if its plan is right with it and wrong without it, and lost the
other way round. Each scenario of a corpus is held out from costs and parser. Commands that
imitate people (``--set``) are followed with all trees of their texts.
"""

from __future__ import annotations

import functools
import itertools
import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
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
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.importers.authored.bundled import open_corpus
from eval.table_3.following import follow_command
from eval.table_3.held_out import costs_without, data_of, parser_without
from eval.table_3.judged_commands import judged_commands
from eval.table_3.outcomes import Outcome
from g3.inference.grounder import Grounder
from g3.inference.potentials.potential_registry import heard, potentials
from g3.inference.problem.costs import Scorer
from g3.inference.tree_choice import PARSES
from g3.language.parsing.parser import parse_unsure
from g3.language.parsing.trees import Parse

Attempt = Callable[[str], bool]
"""Function of the name of a potential to leave out, or "", that checks a command's plan."""


def attempts_of_corpus(train: Sequence[Corpus], name: str) -> Iterator[Attempt]:
    """Yield the commands of a corpus, with each scenario held out in turn."""
    costs = costs_without(data_of(train), load_choices_of(train))
    parsers = parser_without(train)
    commands = sorted(judged_commands(open_corpus(name)), key=lambda c: c.command.scenario)
    for scenario, group in itertools.groupby(commands, key=lambda c: c.command.scenario):
        for command in group:
            clauses = "gold" if command.annotation else "auto"
            texts = [] if command.annotation else [command.command.text]
            trees = parsers(scenario).predict(texts)[0] if texts else ()
            follow = functools.partial(follow_command, clauses, command, trees)
            yield _attempt(follow, costs(scenario))


def attempts_of_sets(train: Sequence[str], sets: Sequence[str]) -> Iterator[Attempt]:
    """Yield the commands of some sets that imitate people."""
    cost = learned_cost(train)
    for record in itertools.chain.from_iterable(map(records_of, sets)):
        parse = parse_unsure(record["text"], n_best=PARSES)
        yield _attempt(functools.partial(_followed, record, parse), cost)


def _followed(record: dict[str, Any], parse: Parse, grounder: Grounder) -> Outcome:
    return followed(record, by_model(grounder, parse))


def _attempt(follow: Callable[[Grounder], Outcome], cost: Scorer) -> Attempt:
    return lambda off: follow(Grounder(cost, without=(off,) if off else ())).correct


def effects(corpus: str, attempts: Iterable[Attempt], names: Sequence[str]) -> list[dict[str, Any]]:
    """Return the counts of commands that each potential wins, loses and adds scores to."""
    spoke, won, lost = Counter[str](), Counter[str](), Counter[str]()
    count = 0
    for attempt in attempts:
        count += 1
        with heard() as names_heard:
            right = attempt("")
        for name in filter(names_heard.__contains__, names):
            right_without = attempt(name)
            spoke[name] += 1
            won[name] += right and not right_without
            lost[name] += right_without and not right
    counts = {"won": won, "lost": lost, "spoke": spoke}
    return [
        {"corpus": corpus, "n": count, "name": name} | {k: c[name] for k, c in counts.items()}
        for name in names
    ]


def main() -> None:
    parser = parser_of("potentials_off", __doc__)
    parser.add_argument("--set", action="append", choices=SETS, dest="sets")
    parser.add_argument("--test", default="", help="corpora to follow, with commas between")
    parser.add_argument("--potential", action="append", help="one to switch off, if not each")
    parser.add_argument("--out", type=Path, required=True, help="rows for docs/make_potentials.py")
    options = parser.parse_args()
    names = options.potential or [potential.name for potential in potentials()]
    train = options.train.split(",")
    known = [open_corpus(name) for name in train]
    rows: list[dict[str, Any]] = []
    for corpus in filter(None, options.test.split(",")):
        rows += effects(corpus, attempts_of_corpus(known, corpus), names)
    if options.sets or not options.test:
        rows += effects("written", attempts_of_sets(train, options.sets or SETS), names)
    for row in rows:
        won, lost = row["won"], row["lost"]
        p = binomtest(won, won + lost).pvalue if won + lost else 1.0
        print(f"{row['corpus']:12} {row['name']:20} {won:3} won, {lost:3} lost  sign test {p:.3f}")
    options.out.write_text(json.dumps({"rows": rows}, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
