"""Commands that rule something out: ``python -m benchmarks.ruled_out``.

Requests are combined with clauses that forbid or except some loads, in each position, in yards of
several kinds of loads. Counts the commands whose plan handles a load that was ruled out; the aim
is none. ``--wrong`` shows them. Nothing is counted for or against the rest of a plan.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml

from benchmarks.written_commands import FOLDER, learned_cost, parser_of, state_of
from g3.actions.action_words import PlanWords
from g3.actions.robot_state import State
from g3.inference.grounder import Grounder

COMMANDS = 5000
TEMPLATES: dict[str, list[str]] = yaml.safe_load((FOLDER / "ruled_out.yaml").read_text("utf-8"))
"""Requests, forbidding clauses, exceptions and their positions, with places for nouns."""
KINDS = {
    "tires": "tire-pallet",
    "boxes": "box-pallet",
    "crate": "crate",
    "generator": "generator-pallet",
    "bricks": "bricks-pallet",
}
"""Nouns for loads, and their kinds."""
DECKS, MARKS = ("truck", "trailer"), {"barrel": "barrel", "sign": "sign", "cone": "cone"}


@dataclass(frozen=True, slots=True)
class Forbidden:
    """A command with the ids of the loads that it rules out."""

    text: str
    state: State
    but: frozenset[str]


def forbidden(rng: np.random.Generator) -> Forbidden:
    """Generate a command and its yard."""

    def pick(kind: str) -> str:
        return str(rng.choice(TEMPLATES[kind]))

    nouns = list(rng.choice(list(KINDS), size=3, replace=False))
    things: dict[str, Any] = {}
    spots = [(8, 6), (10, 1), (7, -5), (12, -2), (6, 10), (13, 5), (9, -9)]
    rng.shuffle(spots)
    loads: dict[str, list[str]] = {}
    for noun in nouns:
        for number in range(1, int(rng.integers(1, 3)) + 1):
            name = f"{noun}_{number}"
            things[name] = [KINDS[noun], list(spots.pop())]
            loads.setdefault(noun, []).append(name.replace("_", "-"))
    mark = str(rng.choice(list(MARKS)))
    things |= {"truck_1": ["truck", [20, 9], 0], "trailer_1": ["trailer", [19, -11], 0]}
    things[f"{mark}_1"] = [MARKS[mark], [2, -9]]
    but_noun, noun = nouns[0], nouns[1]
    but = frozenset(loads[but_noun])
    words = {
        "but": f"the {but_noun}",
        "load": f"the {noun}",
        "deck": str(rng.choice(DECKS)),
        "mark": mark,
        **_agreement(but_noun),
    }
    if rng.random() < 0.3 and len(loads[but_noun]) == 2:  # one of two, told by its side
        sides = sorted(loads[but_noun], key=lambda name: things[name.replace("-", "_")][1][1])
        side = int(rng.integers(2))
        words["but"] = f"the {('right', 'left')[side]} {but_noun}"
        but = frozenset({sides[side]})
    if rng.random() < 0.25:
        request, no = pick("everything"), pick("excepting")
        text = f"{request} {no}" if rng.random() < 0.5 else f"{request}, {no}"
    else:
        request = pick("everything" if rng.random() < 0.3 else "requests")
        no, where = pick("forbidding"), pick("positions")
        text = where.format(no=no, request=request, other=pick("others"))
    text = text.format(**words)
    text = text[0].upper() + text[1:] if rng.random() < 0.5 else text
    record = {"things": things, "held": None}
    return Forbidden(text, state_of(record), but)


def _agreement(noun: str) -> dict[str, str]:
    """Return the words that agree with a noun in number."""
    if noun.endswith("s"):
        return {"be": "are", "stay": "stay", "pronoun": "they are", "them": "them"}
    return {"be": "is", "stay": "stays", "pronoun": "it is", "them": "it"}


def commands(count: int, seed: int) -> Iterator[Forbidden]:
    """Generate commands, each by its own number."""
    return (forbidden(np.random.default_rng([seed, number])) for number in range(count))


def handled(grounder: Grounder, command: Forbidden) -> list[str]:
    """Return the actions of a command's plan that handle what it rules out."""
    plan = grounder.follow(command.text, command.state, least=0.0, insist=True).plan
    actions = plan.actions if plan else ()
    return [PlanWords().action(a) for a in actions if a.object_id in command.but]


def main() -> None:
    parser = parser_of("ruled_out", __doc__, "warehouse")
    parser.add_argument("--commands", type=int, default=COMMANDS, help="how many")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--wrong", action="store_true", help="show those that aren't obeyed")
    options = parser.parse_args()
    grounder = Grounder(learned_cost(options.train.split(",")))
    counts: Counter[str] = Counter()
    for command in commands(options.commands, options.seed):
        done = handled(grounder, command)
        counts["handled" if done else "left alone"] += 1
        if done and options.wrong:
            print(f"  {command.text!r}: {'; '.join(done)}", flush=True)
    print(f"{counts['handled']} of {options.commands} handle what is ruled out")


if __name__ == "__main__":
    main()
