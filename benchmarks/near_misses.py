"""The judge by words on logs of known outcome: ``python -m benchmarks.near_misses``.

Each annotated command of a corpus is judged with its own log, which is right, with the logs of
other scenarios in the same layout, which count as wrong though vague words allow some of them, and
with a plan that does nothing.
"""

from __future__ import annotations

import argparse
from collections import Counter

import numpy as np

from corpus_tools.corpus.annotated_trees import annotated_commands
from corpus_tools.importers.authored.bundled import open_corpus
from eval.judging.execution import logged, planned
from eval.judging.judge_validity import cohens_kappa
from eval.judging.words_judge import judge_by_words

CASES = ("own log", "other log", "nothing")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.near_misses", description=__doc__)
    parser.add_argument("--corpus", default="warehouse")
    options = parser.parse_args()
    annotations = annotated_commands(open_corpus(options.corpus).annotations).values()
    contexts = {a.command.scenario: a.context for a in annotations}
    logs = {scenario: logged(context) for scenario, context in contexts.items()}
    counts: Counter[tuple[str, str]] = Counter()
    for annotation in annotations:
        own = annotation.command.scenario
        site = own.split("_")[0]
        cases = [("own log", logs[own]), ("nothing", planned(annotation.context, ()))]
        cases += [
            ("other log", logs[other])
            for other in logs
            if other != own and other.split("_")[0] == site
        ]
        for case, execution in cases:
            verdict = judge_by_words(annotation, execution)
            told = "not judged" if verdict is None else "right" if verdict.correct else "wrong"
            counts[case, told] += 1
    for case in CASES:
        shown = (f"{told} {counts[case, told]}" for told in ("right", "wrong", "not judged"))
        print(f"{case:10} {', '.join(shown)}")
    table = [[counts[case, told] for told in ("wrong", "right")] for case in CASES[1::-1]]
    print(f"kappa of own and other logs: {cohens_kappa(np.array(table, dtype=float)):.2f}")


if __name__ == "__main__":
    main()
