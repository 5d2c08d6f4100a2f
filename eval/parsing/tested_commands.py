"""Training and testing of extraction on commands with annotated SDC trees."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from corpus_tools.corpus.annotated_trees import Annotated, annotated_trees
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.perturbed_commands import with_perturbed_commands
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.progress import OnProgress, no_progress
from eval.parsing.parser_registry import parser_named
from eval.parsing.reference_scores import reference_scores
from eval.parsing.sdc_scores import Comparison, compare
from eval.splits import leave_one_out
from g3.errors import CorpusError
from g3.language.parsing.extractor import DEFAULT_L2, Parse, SDCExtractor, default_extractor
from g3.language.parsing.training.extractor_training import Lesson, prepare
from g3.short_repr import short_repr

AS_TYPED = ""
"""The name of commands that aren't perturbed."""


@short_repr
@dataclass(frozen=True, slots=True)
class SDCChoices:
    """Options of ``ct eval --sdc``.

    Parameters
    ----------
    corpus
        A corpus to divide by scenario, each held out in turn; or
    test
        one to test on, with
    train
        one to train on (with `corpus`: in addition to its other scenarios), or
    model
        a trained model, or
    parser
        the name of another parser; where there is none of these, the bundled extractor.
    l2
        Strength of the regularisation; None for the default.
    perturb
        Perturbations of commands to test in addition to the commands as typed.
    seed
        Random seed of perturbations.
    """

    corpus: str = ""
    train: str = ""
    test: str = ""
    model: Path | None = None
    parser: str = ""
    l2: float | None = None
    perturb: tuple[str, ...] = ()
    seed: int = 0


@short_repr
@dataclass(frozen=True, slots=True)
class TestedCommand:
    """One tested command."""

    annotated: Annotated
    parse: Parse
    comparison: Comparison


@dataclass(frozen=True, slots=True)
class _Tested:
    """Commands with their trees, and ready to be parsed or learned from."""

    items: Sequence[Annotated]
    lessons: Sequence[Lesson]


def run(
    choices: SDCChoices, on_progress: OnProgress = no_progress
) -> tuple[dict[str, list[TestedCommand]], dict[str, object]]:
    """Extract the trees of all tested commands and compare them with the annotated ones.

    Returns
    -------
    dict of str to list of TestedCommand
        By perturbation, the commands as typed first; each in the order of the corpus.
    dict
        Metadata to record with the figures.
    """
    l2 = DEFAULT_L2 if choices.l2 is None else choices.l2
    corpus = open_corpus(choices.corpus or choices.test)
    tested = {AS_TYPED: _prepared(corpus)}
    for kind in choices.perturb:
        tested[kind] = _prepared(with_perturbed_commands(corpus, kind, seed=choices.seed))
    items = tested[AS_TYPED].items
    metadata: dict[str, object] = {"test": corpus.name, "test_hash": corpus.hash}
    metadata |= asdict(reference_scores(corpus.annotations))
    if choices.perturb:
        metadata |= {"perturb": list(choices.perturb), "seed": choices.seed}
    taught: list[Lesson] = []
    if choices.train:
        training = open_corpus(choices.train)
        taught = _taught(training, items)
        metadata |= {"train": training.name, "train_hash": training.hash}
    if choices.corpus:
        found = _cross_validated(tested, taught, l2, on_progress)
        return found, {**metadata, "cv": "scenario", "l2": l2}
    if choices.parser:
        return _by_parser(choices.parser, tested), {**metadata, "parser": choices.parser}
    if choices.train:
        extractor = SDCExtractor(l2=l2).fit(taught)
        metadata |= {"l2": l2}
    else:
        model = choices.model
        extractor = SDCExtractor.load(model) if model else default_extractor()
        metadata |= {"model": str(model or "bundled")}
        metadata |= {"seen_scenarios": seen_scenarios(extractor, items)}
    return {kind: _parsed(extractor, own) for kind, own in tested.items()}, metadata


def _by_parser(name: str, tested: Mapping[str, _Tested]) -> dict[str, list[TestedCommand]]:
    """Parse the commands with a registered parser."""
    parser = parser_named(name)
    return {
        kind: [_compared(item, parser.parse(item.command.text)) for item in own.items]
        for kind, own in tested.items()
    }


def _compared(item: Annotated, parse: Parse) -> TestedCommand:
    return TestedCommand(item, parse, compare(parse.sdcs, item.sdcs, item.command.text))


def _prepared(corpus: Corpus) -> _Tested:
    items = annotated_trees(corpus)
    return _Tested(items, prepare(items))


def _taught(training: Corpus, tested: Sequence[Annotated]) -> list[Lesson]:
    """Return another corpus's commands to train on; no scenario may be tested."""
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
    """Return tested scenarios that the model was trained on; scores are too high there."""
    known = extractor.card_.get("scenarios", ())
    tested = {item.command.scenario for item in items}
    return sorted(tested & set(known)) if isinstance(known, (list, tuple)) else []


def _cross_validated(
    tested: Mapping[str, _Tested],
    others: Sequence[Lesson],
    l2: float,
    on_progress: OnProgress,
) -> dict[str, list[TestedCommand]]:
    items, lessons = tested[AS_TYPED].items, tested[AS_TYPED].lessons
    splits = leave_one_out([item.command.scenario for item in items])
    found: dict[str, dict[int, TestedCommand]] = {kind: {} for kind in tested}
    for number, split in enumerate(splits):
        on_progress(f"without {split.name}", number, len(splits))
        taught = [lessons[i] for i in split.train]
        extractor = SDCExtractor(l2=l2).fit(taught, others=others)
        for kind, own in tested.items():
            part = _Tested(*([one[i] for i in split.test] for one in (own.items, own.lessons)))
            found[kind] |= zip(split.test.tolist(), _parsed(extractor, part), strict=True)
    return {kind: [own[i] for i in range(len(items))] for kind, own in found.items()}


def _parsed(extractor: SDCExtractor, tested: _Tested) -> list[TestedCommand]:
    parses = extractor.predict_proba([lesson.command for lesson in tested.lessons])
    return [_compared(item, parse) for item, parse in zip(tested.items, parses, strict=True)]
