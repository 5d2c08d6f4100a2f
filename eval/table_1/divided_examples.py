"""Training and test examples, by the command line's options: corpora, examples, splits."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from corpus_tools import __version__
from corpus_tools.corpus.corpus_model import Corpus, draw_parts
from corpus_tools.corpus.labelled_corpus import Negatives, labelled_examples, scenario_ids
from corpus_tools.importers.authored.bundled import open_corpus
from eval.splits import Split, hold_out, leave_one_out, read_scenarios
from g3.errors import CorpusError
from g3.features.feature_registry import CATALOGUE_VERSION, FEATURES, FeatureSet, select
from g3.learning.examples import Example
from g3.learning.grounding_model import DEFAULT_L2, GroundingModel
from g3.short_repr import short_repr

Division = Literal["cv", "split"]
Metadata = dict[str, object]


@short_repr
@dataclass(frozen=True, slots=True)
class Choices:
    """Options of ``ct eval``.

    Parameters
    ----------
    corpus
        The corpus to divide; or
    train, test
        one to train on and one to test on; or
    model
        a trained model, and ``test``.
    division
        Division of ``corpus`` by scenario: each held out in turn, or some.
    test_scenarios
        Scenarios to hold out (:func:`eval.splits.read_scenarios`); drawn if empty.
    test_negatives
        Kind of negatives to test on, if it differs from the kind to train on.
    ablate
        Feature sets to leave out, and potentials, which only plans depend on.
    plus
        Feature sets to add.
    l2
        Strength of the regularisation; None for the default.
    threshold
        Probability from which φ counts as predicted true.
    """

    corpus: str = ""
    train: str = ""
    test: str = ""
    model: Path | None = None
    division: Division = "split"
    test_scenarios: str = ""
    negatives: Negatives = "random"
    test_negatives: Negatives | None = None
    ablate: tuple[str, ...] = ()
    plus: tuple[str, ...] = ()
    l2: float | None = None
    threshold: float = 0.5
    seed: int = 0

    @property
    def tested_negatives(self) -> Negatives:
        """Kind of negatives to test on."""
        return self.test_negatives or self.negatives

    @property
    def strength(self) -> float:
        """Strength of the regularisation."""
        return DEFAULT_L2 if self.l2 is None else self.l2


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class DividedExamples:
    """Examples and their splits."""

    items: Sequence[Example]
    splits: Sequence[Split]
    metadata: Metadata


def chosen_sets(choices: Choices) -> tuple[FeatureSet, ...]:
    """Return the feature sets to train; ablated potentials change no factor."""
    return select(without=ablated(choices)[0], plus=choices.plus)


def ablated(choices: Choices) -> tuple[frozenset[str], frozenset[str]]:
    """Return the names of the feature sets and of the potentials that are left out."""
    names = frozenset(choices.ablate)
    if names <= FEATURES.keys():
        return names, frozenset()
    # Only plans need potentials.
    from g3.inference.potentials.potential_registry import ablation  # noqa: PLC0415

    definition = ablation(names)
    return definition.sets, definition.potentials


def set_up(choices: Choices) -> DividedExamples:
    """Read the corpora and divide the examples."""
    return _two_corpora(choices) if choices.train else _one_corpus(choices)


def set_up_model(choices: Choices) -> tuple[GroundingModel, Sequence[Example], Metadata]:
    """Read a trained model and the examples to test it on."""
    if choices.model is None:
        raise ValueError("there is no model")
    model = GroundingModel.load(choices.model)
    corpus = open_corpus(choices.test)
    items = _examples(corpus, choices.tested_negatives, choices)
    card = model.card or {}
    _refuse_shared(set(card["scenarios"]), items, choices.test)
    metadata = {
        **_common(choices),
        "protocol": "a trained model on a test corpus",
        "train_corpus": card["corpus_hash"],
        "test_corpus": corpus.hash,
        "is_authored": corpus.is_authored,
        "feature_sets": list(model.space_.sets),
        "l2": model.l2,
        "model_training": card["training"],
        "test_examples": by_source(items),
    }
    return model, items, metadata


def _one_corpus(choices: Choices) -> DividedExamples:
    corpus = open_corpus(choices.corpus)
    items = _examples(corpus, choices.negatives, choices)
    tested = items
    if choices.tested_negatives != choices.negatives:
        tested = _examples(corpus, choices.tested_negatives, choices)
    scenario_names = sorted(set(scenarios(items)))
    metadata = {
        **_training(choices),
        "corpus": corpus.hash,
        "is_authored": corpus.is_authored,
    }
    if choices.division == "cv":
        metadata |= {
            "protocol": "leave one scenario out",
            "test_scenarios": scenario_names,
            "test_examples": by_source(tested),
        }
        return _divided(items, tested, leave_one_out, metadata)
    if choices.test_scenarios:
        held_out = read_scenarios(choices.test_scenarios, scenario_names)
    else:
        held_out = draw_parts(scenario_names, seed=choices.seed)
    metadata |= {"protocol": "held-out scenarios", "test_scenarios": list(held_out)}
    divided = _divided(items, tested, lambda names: [hold_out(names, held_out)], metadata)
    return replace(divided, metadata=metadata | _sides(divided.items, divided.splits[0]))


def _divided(
    items: Sequence[Example],
    tested: Sequence[Example],
    divide: Callable[[Sequence[str]], Sequence[Split]],
    metadata: Metadata,
) -> DividedExamples:
    """Divide examples by their scenarios; test examples may differ from training ones."""
    splits = divide(scenarios(items))
    if tested is items:
        return DividedExamples(items, splits, metadata)
    behind = [len(items) + split.test for split in divide(scenarios(tested))]
    return DividedExamples(
        [*items, *tested],
        [replace(split, test=test) for split, test in zip(splits, behind, strict=True)],
        metadata,
    )


def _two_corpora(choices: Choices) -> DividedExamples:
    train, test = open_corpus(choices.train), open_corpus(choices.test)
    training = _examples(train, choices.negatives, choices)
    unseen = _examples(test, choices.tested_negatives, choices)
    _refuse_shared(scenario_ids(training), unseen, choices.test)
    items = [*training, *unseen]
    split = Split(test.name, np.arange(len(training)), np.arange(len(training), len(items)))
    metadata = {
        **_training(choices),
        "protocol": "a training and a test corpus",
        "train_corpus": train.hash,
        "test_corpus": test.hash,
        "is_authored": test.is_authored,
        **_sides(items, split),
    }
    return DividedExamples(items, [split], metadata)


def _examples(corpus: Corpus, negatives: Negatives, choices: Choices) -> list[Example]:
    return labelled_examples(corpus, negatives=negatives, seed=choices.seed)


def _refuse_shared(trained: AbstractSet[str], tested: Iterable[Example], where: str) -> None:
    shared = sorted(trained & scenario_ids(tested))
    if shared:
        name = shared[0].rpartition(" ")[0]
        raise CorpusError(
            f"scenario {name!r} is on the training side too ({len(shared)} such in all), "
            "so the test would say nothing",
            where=where,
            fix="test on other scenarios, or divide one corpus with --corpus and --cv or --split",
        )


def scenarios(items: Iterable[Example]) -> list[str]:
    """Return the scenario of each example."""
    return [e.annotation.command.scenario for e in items]


def by_source(items: Iterable[Example]) -> dict[str, int]:
    """Count examples by the source of their groundings."""
    return dict(sorted(Counter(e.source for e in items).items()))


def _sides(items: Sequence[Example], split: Split) -> Metadata:
    return {
        "train_examples": by_source(items[i] for i in split.train),
        "test_examples": by_source(items[i] for i in split.test),
    }


def _common(choices: Choices) -> Metadata:
    return {
        "program": f"ct {__version__}",
        "catalogue_version": CATALOGUE_VERSION,
        "negatives": choices.negatives,
        "test_negatives": choices.tested_negatives,
        "threshold": choices.threshold,
        "seed": choices.seed,
    }


def _training(choices: Choices) -> Metadata:
    return {
        **_common(choices),
        "ablated": list(choices.ablate),
        "added": list(choices.plus),
        "l2": choices.strength,
    }
