"""Potentials on commands that imitate people: ``python -m benchmarks.written_on_trial --out FILE``.

As ``ct eval --on-trial`` does it, but all trees of a text are tried, so that potentials of plans
have a record, too. Those have learned their weights from the first seven sets.
"""

from __future__ import annotations

import functools
import json
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.written_commands import (
    SETS,
    by_model,
    followed,
    learned_cost,
    parser_of,
    records_of,
)
from corpus_tools.runtime.parallel import Workers, work
from eval.on_trial.ablation_report import rows
from eval.on_trial.ablation_runs import NOTHING
from eval.table_3.outcomes import Outcome
from g3.inference.grounder import Grounder
from g3.inference.potentials.potential_registry import heard, potentials
from g3.inference.problem.costs import Scorer
from g3.inference.tree_choice import PARSES
from g3.language.parsing.extractor import Parse
from g3.language.parsing.parser import parse_unsure

CORPUS = "written"
Yard = tuple[str, str]
"""A set and a yard of it."""


@functools.lru_cache(maxsize=1)
def _cost(train: str) -> Scorer:
    return learned_cost(train.split(","))


def of_yard(yard: Yard, *, train: str, names: Sequence[str]) -> list[tuple[str, Outcome]]:
    """What becomes of a yard's commands, by what is switched off; what says nothing is left out."""
    own = [record for record in records_of(yard[0]) if record["world"] == yard[1]]
    found: list[tuple[str, Outcome]] = []
    for number, record in enumerate(own):
        parse = parse_unsure(record["text"], n_best=PARSES)
        one = functools.partial(_outcome, record, f"{yard[1]}-{number}", parse, _cost(train))
        with heard() as said:
            found.append((NOTHING, one("")))
        found += [(name, one(name)) for name in names if name in said]
    return found


def _outcome(record: dict[str, Any], name: str, parse: Parse, cost: Scorer, off: str) -> Outcome:
    plan = by_model(Grounder(cost, without=(off,) if off else ()), parse)
    return followed(record, plan, name)


def main() -> None:
    parser = parser_of("written_on_trial", __doc__)
    parser.add_argument("--potential", action="append", help="one to switch off, if not each")
    parser.add_argument("--jobs", type=int, default=1, help="how many processes work")
    parser.add_argument("--out", type=Path, required=True, help="rows for docs/make_potentials.py")
    options = parser.parse_args()
    yards = [
        (name, world)
        for name in options.sets or SETS
        for world in dict.fromkeys(record["world"] for record in records_of(name))
    ]
    by_name: dict[str, list[Outcome]] = defaultdict(list)
    names = options.potential or [p.name for p in potentials()]
    task = functools.partial(of_yard, train=options.train, names=names)
    for number, done in enumerate(work(task, yards, Workers(options.jobs)), start=1):
        if done.result is None:
            raise done.error or RuntimeError(done.item)
        for name, outcome in done.result:
            by_name[name].append(outcome)
        print(f"{number} of {len(yards)} yards", flush=True)
    found = rows({CORPUS: by_name}, [(name, "potential") for name in names])
    options.out.write_text(json.dumps({"rows": found}, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
