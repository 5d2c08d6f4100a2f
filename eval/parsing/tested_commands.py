"""Extraction of SDC trees from commands whose trees are annotated: what is trained and tested."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from corpus_tools.corpus.annotated_trees import Annotated, annotated_trees
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.progress import OnProgress, no_progress
from eval.parsing.reference_scores import reference_scores
from eval.parsing.sdc_scores import Comparison, compare
from eval.splits import leave_one_out
from g3.errors import CorpusError
from g3.language.parsing.extractor import DEFAULT_L2, Parse, SDCExtractor, default_extractor
from g3.language.parsing.training.extractor_training import Lesson, prepare


@dataclass(frozen=True, slots=True)
class SDCChoices:
    """What the options of ``ct eval --sdc`` say.

    Parameters
    ----------
    corpus
        A corpus to divide by scenario, each held out in turn; or
    test
        one to test on, with
    train
        one to train on (with `corpus`: besides its other scenarios), or
    model
        a trained model; where there is neither, the bundled one.
    l2
        Strength of the regularisation; None for the default.
    """

    corpus: str = ""
    train: str = ""
    test: str = ""
    model: Path | None = None
    l2: float | None = None


@dataclass(frozen=True, slots=True)
class TestedCommand:
    """One tested command."""

    annotated: Annotated
    parse: Parse
    comparison: Comparison


def run(
    choices: SDCChoices, on_progress: OnProgress = no_progress
) -> tuple[list[TestedCommand], dict[str, object]]:
    """Extract the trees of all tested commands and compare them with the annotated ones.

    Returns
    -------
    list of TestedCommand
        In the order of the corpus.
    dict
        What to record with the figures.
    """
    l2 = DEFAULT_L2 if choices.l2 is None else choices.l2
    corpus = open_corpus(choices.corpus or choices.test)
    items = annotated_trees(corpus)
    lessons = prepare(items)
    metadata: dict[str, object] = {"test": corpus.name, "test_hash": corpus.hash}
    metadata |= asdict(reference_scores(corpus.annotations))
    taught: list[Lesson] = []
    if choices.train:
        training = open_corpus(choices.train)
        taught = _taught(training, items)
        metadata |= {"train": training.name, "train_hash": training.hash}
    if choices.corpus:
        tested = _cross_validated(items, lessons, taught, l2, on_progress)
        return tested, {**metadata, "cv": "scenario", "l2": l2}
    if choices.train:
        extractor = SDCExtractor(l2=l2).fit(taught)
        metadata |= {"l2": l2}
    else:
        model = choices.model
        extractor = SDCExtractor.load(model) if model else default_extractor()
        metadata |= {"model": str(model or "bundled")}
        metadata |= {"seen_scenarios": seen_scenarios(extractor, items)}
    return _tested(extractor, items, lessons), metadata


def _taught(training: Corpus, tested: Sequence[Annotated]) -> list[Lesson]:
    """The commands of another corpus, none of a scenario that is tested."""
    items = annotated_trees(training)
    both = {i.command.scenario for i in items} & {i.command.scenario for i in tested}
    if both:
        raise CorpusError(
            f"the scenario {sorted(both)[0]!r} is in both corpora",
            where="--train",
            fix="use --corpus with --cv scenario alone, or corpora of different scenarios",
        )
    return prepare(items)


def seen_scenarios(extractor: SDCExtractor, items: Iterable[Annotated]) -> list[str]:
    """Scenarios of tested commands that the model was trained on: figures are too good there."""
    known = extractor.card_.get("scenarios", ())
    tested = {item.command.scenario for item in items}
    return sorted(tested & set(known)) if isinstance(known, (list, tuple)) else []


def _cross_validated(
    items: Sequence[Annotated],
    lessons: Sequence[Lesson],
    others: Sequence[Lesson],
    l2: float,
    on_progress: OnProgress,
) -> list[TestedCommand]:
    splits = leave_one_out([item.command.scenario for item in items])
    tested: dict[int, TestedCommand] = {}
    for number, split in enumerate(splits):
        on_progress(f"without {split.name}", number, len(splits))
        taught = [lessons[i] for i in split.train]
        extractor = SDCExtractor(l2=l2).fit(taught, others=others)
        own = _tested(extractor, [items[i] for i in split.test], [lessons[i] for i in split.test])
        tested |= zip(split.test.tolist(), own, strict=True)
    return [tested[i] for i in range(len(items))]


def _tested(
    extractor: SDCExtractor, items: Sequence[Annotated], lessons: Sequence[Lesson]
) -> list[TestedCommand]:
    parses = extractor.predict_proba([lesson.command for lesson in lessons])
    return [
        TestedCommand(item, parse, compare(parse.sdcs, item.sdcs, item.command.text))
        for item, parse in zip(items, parses, strict=True)
    ]
