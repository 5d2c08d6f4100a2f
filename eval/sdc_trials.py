"""Extraction of SDC trees from commands whose trees are annotated: what is trained and tested."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from corpus_tools.bundled import open_corpus
from corpus_tools.corpus.model import Corpus
from corpus_tools.trees import Annotated, annotated_trees
from eval.reference_scores import reference_scores
from eval.sdc_scores import Comparison, compare
from g3.errors import CorpusError
from g3.language.extractor import Extractor, Parse, extract_analysed
from g3.language.extractor_file import default_extractor, from_bytes
from g3.language.extractor_training import DEFAULT_L2, Lesson, prepare, train_extractor
from g3.sdc import SDC

OnProgress = Callable[[str, int, int], None]
BATCH = 256


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
        a trained model; where there is neither, the one that comes along.
    l2
        Strength of the regularisation; None for the default.
    """

    corpus: str = ""
    train: str = ""
    test: str = ""
    model: Path | None = None
    l2: float | None = None


@dataclass(frozen=True, slots=True)
class Trial:
    """One tested command."""

    annotated: Annotated
    parse: Parse
    comparison: Comparison


def run(
    choices: SDCChoices, on_progress: OnProgress | None = None
) -> tuple[list[Trial], dict[str, object]]:
    """Extract the trees of all tested commands and compare them with the annotated ones.

    Returns
    -------
    list of Trial
        In the order of the corpus.
    dict
        What to record with the figures.
    """
    l2 = DEFAULT_L2 if choices.l2 is None else choices.l2
    corpus = open_corpus(choices.corpus or choices.test)
    items = annotated_trees(corpus)
    lessons = prepare(_texts_and_trees(items))
    metadata: dict[str, object] = {"test": corpus.name, "test_hash": corpus.hash}
    metadata |= asdict(reference_scores(corpus.annotations))
    taught: list[Lesson] = []
    if choices.train:
        training = open_corpus(choices.train)
        taught = _taught(training, items)
        metadata |= {"train": training.name, "train_hash": training.hash}
    if choices.corpus:
        trials = _cross_validated(items, lessons, taught, l2, on_progress)
        return trials, {**metadata, "cv": "scenario", "l2": l2}
    if choices.train:
        extractor = train_extractor(taught, l2=l2)
        metadata |= {"l2": l2}
    else:
        extractor = _trained(choices.model)
        metadata |= {"model": str(choices.model or "the one that comes along")}
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
    return prepare(_texts_and_trees(items))


def _texts_and_trees(items: Iterable[Annotated]) -> list[tuple[str, tuple[SDC, ...]]]:
    return [(item.command.text, item.sdcs) for item in items]


def seen_scenarios(extractor: Extractor, items: Iterable[Annotated]) -> list[str]:
    """Scenarios of tested commands that the model was trained on: figures are too good there."""
    known = extractor.card.get("scenarios", ())
    tested = {item.command.scenario for item in items}
    return sorted(tested & set(known)) if isinstance(known, (list, tuple)) else []


def _trained(model: Path | None) -> Extractor:
    if model is None:
        return default_extractor()
    try:
        return from_bytes(model.read_bytes(), where=str(model))
    except OSError as error:
        raise CorpusError(
            f"the model can't be read: {error.strerror}",
            where=str(model),
            fix="give what 'ct train sdc --out' wrote",
        ) from error


def _cross_validated(
    items: Sequence[Annotated],
    lessons: Sequence[Lesson],
    others: Sequence[Lesson],
    l2: float,
    on_progress: OnProgress | None,
) -> list[Trial]:
    scenarios = sorted({item.command.scenario for item in items})
    if len(scenarios) < 2:
        raise CorpusError(
            "there is only one scenario, so none can be held out", fix="use --train and --test"
        )
    found: dict[str, Trial] = {}
    for number, scenario in enumerate(scenarios):
        if on_progress is not None:
            on_progress(f"without {scenario}", number, len(scenarios))
        held = [i for i, item in enumerate(items) if item.command.scenario == scenario]
        own = zip(items, lessons, strict=True)
        taught = [lesson for i, lesson in own if i.command.scenario != scenario]
        extractor = train_extractor(taught, others=others, l2=l2)
        trials = _tested(extractor, [items[i] for i in held], [lessons[i] for i in held])
        found |= {trial.annotated.command.id: trial for trial in trials}
    return [found[item.command.id] for item in items]


def _tested(
    extractor: Extractor, items: Sequence[Annotated], lessons: Sequence[Lesson]
) -> list[Trial]:
    commands = [lesson.command for lesson in lessons]
    parses = [
        parse
        for start in range(0, len(commands), BATCH)
        for parse in extract_analysed(extractor, commands[start : start + BATCH])
    ]
    return [
        Trial(item, parse, compare(parse.sdcs, item.sdcs, item.command.text))
        for item, parse in zip(items, parses, strict=True)
    ]
