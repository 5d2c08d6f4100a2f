"""How often plans do what words say: ``python -m benchmarks.said_and_done --test automatic``."""

from __future__ import annotations

import argparse
from collections import Counter

from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.corpus.task_outcomes import contexts_of_commands
from corpus_tools.importers.authored.bundled import open_corpus
from eval.judging.as_said import RELATIONS, done_as_said, mentions
from eval.table_3.held_out import costs_without, extractor_without
from eval.table_3.search_examples import data_of
from g3.actions.action_words import described
from g3.inference.grounder import Grounder


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.said_and_done", description=__doc__)
    parser.add_argument("--train", default="warehouse", help="corpora, with commas between")
    parser.add_argument("--test", default="warehouse", help="a corpus; its scenarios are held out")
    parser.add_argument("--ablate", action="append", default=[], help="a potential to leave out")
    parser.add_argument("--wrong", action="store_true", help="show what isn't done as said")
    arguments = parser.parse_args()
    known = [open_corpus(name) for name in arguments.train.split(",")]
    tested = open_corpus(arguments.test)
    costs = costs_without(data_of(known), load_choices_of(known))
    extractors = extractor_without(known)
    worlds = {c: tested.contexts[world] for c, world in contexts_of_commands(tested).items()}
    worlds |= {a.command.id: a.context for a in tested.annotations}
    right: Counter[str] = Counter()
    total: Counter[str] = Counter()
    for command in sorted(tested.commands.values(), key=lambda c: (c.scenario, c.id)):
        found = list(mentions(command.text))
        if not found or command.id not in worlds:
            continue
        world = worlds[command.id]
        [sdcs] = extractors(command.scenario).predict([command.text])
        grounder = Grounder(costs(command.scenario), without=arguments.ablate)
        plan = grounder.follow(sdcs, world, least=0.0, insist=True).plan
        for mention in found:
            done = plan is not None and done_as_said(mention, sdcs, world, plan)
            total[mention.relation] += 1
            right[mention.relation] += done
            if arguments.wrong and not done:
                actions = "; ".join(map(described, plan.actions)) if plan else "no plan"
                print(f"  {mention.relation}: {command.text!r}: {actions}")
    for name in (*RELATIONS, "all"):
        does, said = (sum(c.values()) if name == "all" else c[name] for c in (right, total))
        if said:
            print(f"{name:12} {does:4} of {said:4}  {does / said:.2f}")


if __name__ == "__main__":
    main()
