"""Commands that rule something out: ``python -m benchmarks.ruled_out``.

Requests are combined with clauses that forbid or except some loads, in each position, in yards of
several kinds of loads. Counts the commands whose plan handles a load that was ruled out; the aim
is none. ``--wrong`` shows them. Nothing is counted for or against the rest of a plan.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.written_commands import learned_cost, state_of
from g3.actions.action_words import described
from g3.actions.robot_state import State
from g3.inference.grounder import Grounder

COMMANDS = 5000
REQUESTS = (
    "put {load} on the {deck}",
    "pick up {load}",
    "move {load} next to the {mark}",
    "take {load} over to the {deck}",
    "{load} should go on the {deck}",
    "{load} to the {deck}",
    "load {load} onto the {deck}",
    "grab {load}",
    "go to the {mark}",
    "I want {load} by the {mark}",
)
"""Requests about loads that aren't ruled out."""
EVERYTHING = (
    "put everything on the {deck}",
    "move all the loads to the {deck}",
    "take everything next to the {mark}",
    "load all of it onto the {deck}",
    "bring every load to the {deck}",
)
"""Requests about all loads."""
FORBIDDING = (
    "don't touch {but}",
    "do not move {but}",
    "dont lift {but}",
    "leave {but} alone",
    "leave {but} where {pronoun}",
    "never move {but}",
    "{but} must not be moved",
    "{but} {be} not to be touched",
    "{but} {be} to stay where {pronoun}",
    "{but} should stay put",
    "{but} {stay} where {pronoun}",
    "{but} shall not be moved",
    "{but} {be} reserved, do not move {them}",
    "keep your forks off {but}",
    "hands off {but}",
    "under no circumstances move {but}",
    "make sure you don't touch {but}",
    "I don't want {but} moved",
    "nobody touches {but}",
    "don't you dare move {but}",
)
"""Clauses that forbid to handle loads."""
EXCEPTING = (
    "except {but}",
    "but not {but}",
    "apart from {but}",
    "other than {but}",
    "excluding {but}",
    "with the exception of {but}",
    "just not {but}",
    "not {but} though",
)
"""Exceptions behind a request about everything."""
POSITIONS = (
    "{no}, {request}",
    "{no}. {request}.",
    "{no} and {request}",
    "{request}, {no}",
    "{request}. {no}.",
    "{request} but {no}",
    "{request} ({no})",
    "{request}; {no}",
    "{no}! {request}!",
    "{other}, {no}, then {request}",
    "{other} then {request} and {no}",
)
"""Positions of a forbidding clause."""
OTHERS = ("go to the {mark}", "turn around", "drive to the {deck}")
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
        request, no = str(rng.choice(EVERYTHING)), str(rng.choice(EXCEPTING))
        text = f"{request} {no}" if rng.random() < 0.5 else f"{request}, {no}"
    else:
        request = str(rng.choice(EVERYTHING if rng.random() < 0.3 else REQUESTS))
        no, where = str(rng.choice(FORBIDDING)), str(rng.choice(POSITIONS))
        text = where.format(no=no, request=request, other=str(rng.choice(OTHERS)))
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
    return [described(a) for a in actions if a.object_id in command.but]


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ruled_out", description=__doc__)
    parser.add_argument("--train", default="warehouse", help="corpora, with commas between")
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
