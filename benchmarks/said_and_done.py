"""Rate of plans that do what words say: ``python -m benchmarks.said_and_done --test automatic``.

``--worlds`` measures it in generated worlds, each with commands in many wordings.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import TypeAlias

from benchmarks.stated_relations import RELATIONS, fulfils_relation, mentions
from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.corpus.task_outcomes import contexts_of_commands
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.shipped import bundled
from corpus_tools.world.scenarios.contexts import scenario_context
from corpus_tools.world.scenarios.random_scenarios import generate
from corpus_tools.world.scenarios.scenario_reading import read_layouts
from eval.table_3.held_out import costs_without, data_of, parser_without
from g3.actions.action_words import described
from g3.actions.robot_state import is_load, start_state
from g3.groundings import Context
from g3.inference.grounder import Grounder
from g3.sdc.clauses import SDC

WORDINGS = (
    "Drive away from the {thing}.",
    "Move away from the {thing} and stop.",
    "Go to the {thing}, then back away from it.",
    "Turn left and get away from the {thing}.",
    "Pick up the {load} and drive away from the {thing}.",
    "Please reverse slowly away from the {thing}.",
    "Drive past the {thing}.",
    "Go forward past the {thing} and turn right.",
    "Pass the {thing}.",
    "Continue past the {thing}, then go to the {load}.",
    "Pick up the {load} and move past the {thing}.",
    "You need to proceed past the {thing}.",
    "Raise the forks.",
    "Go to the {thing} and lift your forks.",
    "Raise your forks, then drive to the {thing}.",
    "Please elevate the mechanical fork.",
    "Turn around and raise the forklift.",
    "Drive up to the {load} and raise the forks a bit.",
)
"""Commands in each generated world, about a load and another thing."""

Asked: TypeAlias = tuple[str, Sequence[SDC], Context, Callable[[], Grounder]]


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.said_and_done", description=__doc__)
    parser.add_argument("--train", default="warehouse", help="corpora, with commas between")
    parser.add_argument("--test", default="warehouse", help="a corpus; its scenarios are held out")
    parser.add_argument("--worlds", type=int, default=0, help="so many generated worlds instead")
    parser.add_argument("--seed", type=int, default=0, help="of the generated worlds")
    parser.add_argument("--ablate", action="append", default=[], help="a potential to leave out")
    parser.add_argument("--wrong", action="store_true", help="show what isn't done as said")
    options = parser.parse_args()
    told = _of_worlds(options) if options.worlds else _of_corpus(options)
    right: Counter[str] = Counter()
    total: Counter[str] = Counter()
    for text, sdcs, world, grounder in told:
        plan = grounder().follow(sdcs, world, least=0.0, insist=True).plan
        for mention in mentions(text):
            done = plan is not None and fulfils_relation(mention, sdcs, world, plan)
            total[mention.relation] += 1
            right[mention.relation] += done
            if options.wrong and not done:
                actions = "; ".join(map(described, plan.actions)) if plan else "no plan"
                print(f"  {mention.relation}: {text!r}: {actions}")
    for name in (*RELATIONS, "all"):
        does, said = (sum(c.values()) if name == "all" else c[name] for c in (right, total))
        if said:
            print(f"{name:12} {does:4} of {said:4}  {does / said:.2f}")


def _of_corpus(options: argparse.Namespace) -> Iterator[Asked]:
    """Yield the commands of a corpus that specify something measurable, with scenarios held out."""
    known = [open_corpus(name) for name in options.train.split(",")]
    tested = open_corpus(options.test)
    costs = costs_without(data_of(known), load_choices_of(known))
    parsers = parser_without(known)
    worlds = {c: tested.contexts[world] for c, world in contexts_of_commands(tested).items()}
    worlds |= {a.command.id: a.context for a in tested.annotations}
    for command in sorted(tested.commands.values(), key=lambda c: (c.scenario, c.id)):
        if not any(mentions(command.text)) or command.id not in worlds:
            continue
        [sdcs] = parsers(command.scenario).predict([command.text])

        def grounder(scenario: str = command.scenario) -> Grounder:
            return Grounder(costs(scenario), without=options.ablate)

        yield command.text, sdcs, worlds[command.id], grounder


def _of_worlds(options: argparse.Namespace) -> Iterator[Asked]:
    """Yield all wordings in generated worlds, which no corpus has."""
    known = [open_corpus(name) for name in options.train.split(",")]
    cost = costs_without(data_of(known), load_choices_of(known))("")
    parser = parser_without(known)("")
    grounder = Grounder(cost, without=options.ablate)
    layouts = read_layouts(bundled()["warehouse"])
    for number in range(options.worlds):
        world = scenario_context(generate(options.seed, number, layouts))
        loads, things = _names(world)
        for i, wording in enumerate(WORDINGS):
            text = wording.format(load=loads[i % len(loads)], thing=things[i % len(things)])
            [sdcs] = parser.predict([text])
            yield text, sdcs, world, lambda: grounder


def _names(world: Context) -> tuple[list[str], list[str]]:
    """Return the names of a world's loads and other things; loads where there are no others."""
    state = start_state(world)
    names: dict[bool, list[str]] = {True: [], False: []}
    for thing in world.objects:
        if thing.id != world.agent_id:
            names[is_load(state, thing.id)].append(" ".join(thing.labels))
    loads = list(dict.fromkeys(names[True])) or ["crate"]
    return loads, list(dict.fromkeys(names[False])) or loads


if __name__ == "__main__":
    main()
