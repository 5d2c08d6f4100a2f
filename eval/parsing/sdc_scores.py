"""Agreement of extracted SDC trees, and of references, with annotated ones (section 3.1).

A constituent is a clause, known by its type and all words in it and in the clauses below it.
The implicit robot has no words and doesn't count. Words are compared by the letters and digits
that they cover, so that it doesn't matter how either side cuts words and punctuation.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias, TypeVar

from rich.table import Table

from corpus_tools.corpus.annotated_trees import (
    Annotated,
    annotated_commands,
    annotated_trees,
    with_perturbed_commands,
)
from corpus_tools.corpus.corpus_model import Corpus, Division
from corpus_tools.corpus.estimate import Estimate, explained, named, part
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.runtime.text_tables import figure_table
from eval.parsing.parser_registry import ParseTask, TextParser
from eval.splits import Split, leave_one_out
from eval.tables.formats import cell, document, table_text
from g3.annotation import Annotation
from g3.errors import CorpusError
from g3.groundings import Grounding, PhysicalObject
from g3.language.discourse.anaphora import anaphors
from g3.language.discourse.groups import group
from g3.language.parsing.sdc_parser import DEFAULT_L2, SDCParser, default_parser
from g3.language.parsing.training.parser_training import Lesson, prepare
from g3.language.parsing.trees import Parse
from g3.sdc.clauses import SDC, SDC_TYPES, Span, all_words, breadth_first
from g3.sdc.sdc_notation import format_brackets
from g3.short_repr import short_repr
from g3.storage.text_lines import split_lines

T = TypeVar("T")

Letters = frozenset[int]
Constituents: TypeAlias = "Counter[tuple[str, Letters]]"
NOWHERE = "-"
"""Type and field of a word in no clause."""
FIELDS = tuple(f"{type_}.{field}" for type_ in SDC_TYPES for field in ("f", "r"))


@dataclass(frozen=True, slots=True)
class Counts:
    """Sizes of two sides, and of their intersection."""

    same: int = 0
    predicted: int = 0
    gold: int = 0

    def __add__(self, other: Counts) -> Counts:
        return Counts(
            self.same + other.same, self.predicted + other.predicted, self.gold + other.gold
        )

    @property
    def precision(self) -> Estimate:
        """Share of the predicted that is correct; undefined where nothing is predicted."""
        return part(self.same, self.predicted)

    @property
    def recall(self) -> Estimate:
        """Share of the annotated that is predicted; undefined where nothing is annotated."""
        return part(self.same, self.gold)

    @property
    def f(self) -> Estimate:
        """Harmonic mean of the two; undefined where there is nothing on either side."""
        return part(2 * self.same, self.predicted + self.gold)


@short_repr
@dataclass(frozen=True, slots=True)
class Comparison:
    """One command's trees against the annotated ones.

    Parameters
    ----------
    typed, untyped
        Constituents, with and without their types.
    by_type
        Typed constituents of each type.
    segments
        Top-level clauses, matched by their words among those that both sides have in a clause.
    exact
        True if all trees are equal in types, fields and words.
    confusion
        Letters by annotated and predicted type and field of the word that they are in.
    """

    typed: Counts
    untyped: Counts
    by_type: dict[str, Counts]
    segments: Counts
    exact: bool
    confusion: Counter[tuple[str, str]]


def compare(predicted: Sequence[SDC], gold: Sequence[SDC], text: str) -> Comparison:
    """Compare a command's extracted trees with the annotated ones."""
    ours, theirs = _constituents(predicted, text), _constituents(gold, text)
    by_type: dict[str, Counts] = {
        type_: _common(_of_type(ours, type_), _of_type(theirs, type_)) for type_ in SDC_TYPES
    }
    segments = [[_letters(all_words(sdc), text) for sdc in sdcs] for sdcs in (predicted, gold)]
    shared = frozenset().union(*segments[0]) & frozenset().union(*segments[1])
    fields = [_fields(sdcs, text) for sdcs in (predicted, gold)]
    confusion = Counter(
        (fields[1].get(i, NOWHERE), fields[0].get(i, NOWHERE)) for i in {*fields[0], *fields[1]}
    )
    return Comparison(
        typed=_common(ours, theirs),
        untyped=_common(_untyped(ours), _untyped(theirs)),
        by_type=by_type,
        segments=_common(_shared(segments[0], shared), _shared(segments[1], shared)),
        exact=_shape(predicted, text) == _shape(gold, text),
        confusion=confusion,
    )


def _letters(spans: Iterable[Span], text: str) -> Letters:
    return frozenset(i for s in spans for i in range(s.start, s.end) if text[i].isalnum())


def _constituents(sdcs: Sequence[SDC], text: str) -> Constituents:
    result = ((sdc.type, _letters(all_words(sdc), text)) for sdc in breadth_first(sdcs))
    return Counter((type_, letters) for type_, letters in result if letters)


def _shared(segments: Sequence[Letters], shared: Letters) -> Counter[Letters]:
    return Counter(segment & shared for segment in segments if segment & shared)


def _untyped(constituents: Constituents) -> Counter[Letters]:
    return Counter(letters for _, letters in constituents.elements())


def _of_type(constituents: Constituents, type_: str) -> Constituents:
    return Counter({one: count for one, count in constituents.items() if one[0] == type_})


def _common(predicted: Counter[T], gold: Counter[T]) -> Counts:
    return Counts((predicted & gold).total(), predicted.total(), gold.total())


def _fields(sdcs: Sequence[SDC], text: str) -> dict[int, str]:
    return {
        i: f"{sdc.type}.{field}"
        for sdc in breadth_first(sdcs)
        for field, spans in (("f", sdc.words), ("r", sdc.relation))
        for i in _letters(spans, text)
    }


def _shape(sdcs: Sequence[SDC], text: str) -> tuple[object, ...]:
    return tuple(
        (
            sdc.type,
            _letters(sdc.words, text),
            _letters(sdc.relation, text),
            *(_shape(sdc.children(field), text) for field in ("f", "l", "l2")),
        )
        for sdc in sdcs
    )


@dataclass(frozen=True, slots=True)
class ReferenceScores:
    """Counts over the grounded commands of a corpus.

    Parameters
    ----------
    pronouns
        Grounded anaphors of the kind `same`.
    any_antecedent
        Those that have a right antecedent among the candidates.
    first_antecedent
        Those whose most probable antecedent is right.
    singular
        Grounded OBJECTs that are singular by their words.
    singular_of_one
        Those that are grounded in one thing.
    plural
        Grounded OBJECTs that are plural by their words.
    plural_of_one
        Those that are grounded in one thing all the same.
    """

    pronouns: int = 0
    any_antecedent: int = 0
    first_antecedent: int = 0
    singular: int = 0
    singular_of_one: int = 0
    plural: int = 0
    plural_of_one: int = 0


def reference_scores(annotations: Iterable[Annotation]) -> ReferenceScores:
    """Count over the first positive annotation of each command."""
    chosen = annotated_commands(annotations)
    right = [correct for annotation in chosen.values() for correct in _antecedents(annotation)]
    sizes = [size for annotation in chosen.values() for size in _sizes(annotation)]
    singular = [size for number, size in sizes if number == "singular"]
    plural = [size for number, size in sizes if number == "plural"]
    return ReferenceScores(
        pronouns=len(right),
        any_antecedent=sum(any(correct) for correct in right),
        first_antecedent=sum(bool(correct) and correct[0] for correct in right),
        singular=len(singular),
        singular_of_one=singular.count(1),
        plural=len(plural),
        plural_of_one=plural.count(1),
    )


def _antecedents(annotation: Annotation) -> Iterator[list[bool]]:
    """Yield for each grounded pronoun which of its antecedents are right."""
    for anaphor in anaphors(annotation.sdcs):
        meant = _things(annotation.groundings[anaphor.index])
        if anaphor.kind == "same" and meant:
            yield [
                _things(annotation.groundings[antecedent.index]) == meant
                for antecedent in anaphor.antecedents
            ]


def _things(groundings: Iterable[Grounding]) -> frozenset[Grounding | str]:
    return frozenset(g.id if isinstance(g, PhysicalObject) else g for g in groundings)


def _sizes(annotation: Annotation) -> Iterator[tuple[str, int]]:
    """Yield grammatical number and count of groundings of each OBJECT grounded in things."""
    inside: set[int] = set()
    for sdc, groundings in zip(breadth_first(annotation.sdcs), annotation.groundings, strict=True):
        if sdc.type != "OBJECT":
            continue
        inside.update(id(figure) for figure in sdc.figure)
        things = bool(groundings) and all(isinstance(g, PhysicalObject) for g in groundings)
        if things and id(sdc) not in inside and all_words(sdc):
            yield group(sdc).number, len(groundings)


AS_TYPED = ""
"""The name of commands that aren't perturbed."""


@short_repr
@dataclass(frozen=True, slots=True)
class SDCChoices:
    """Options of ``ct eval sdc``.

    Parameters
    ----------
    corpus
        A corpus to divide by `cv`, each part held out in turn; or
    test
        one to test on, with
    train
        one to train on (with `corpus`: in addition to its other parts), or
    model
        a trained model, or
    parser
        another parser, which may learn from the other parts of `corpus`, or from `train`; where
        there is none of these, the bundled parser.
    l2
        Strength of the regularisation; None for the default.
    perturb
        Perturbations of commands to test in addition to the commands as typed.
    seed
        Random seed of perturbations.
    cv
        Division of `corpus`: by scenario, by person or by world.
    """

    corpus: str = ""
    train: str = ""
    test: str = ""
    model: Path | None = None
    parser: TextParser | None = None
    l2: float | None = None
    perturb: tuple[str, ...] = ()
    seed: int = 0
    cv: Division = "scenario"


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
    others: list[Annotated] = []
    if choices.train:
        training = open_corpus(choices.train)
        others = _others(training, items)
        metadata |= {"train": training.name, "train_hash": training.hash}
    splits: list[Split] = []
    if choices.corpus:
        parts = corpus.select(item.command.id for item in items).parts(choices.cv)
        splits = list(leave_one_out([parts[item.command.id] for item in items]))
        metadata |= {"cv": choices.cv}
    if choices.parser:
        parser = choices.parser
        metadata |= {"parser": parser.name, **({"parsed_by": parser.about} if parser.about else {})}
        return _by_parser(parser, tested, splits, others, on_progress), metadata
    taught = prepare(others)
    if splits:
        return _cross_validated(tested, splits, taught, l2, on_progress), {**metadata, "l2": l2}
    if choices.train:
        learned = SDCParser(l2=l2).fit(taught)
        metadata |= {"l2": l2}
    else:
        model = choices.model
        learned = SDCParser.load(model) if model else default_parser()
        metadata |= {"model": str(model or "bundled")}
        metadata |= {"seen_scenarios": seen_scenarios(learned, items)}
    return {kind: _parsed(learned, own) for kind, own in tested.items()}, metadata


def _by_parser(
    parser: TextParser,
    tested: Mapping[str, _Tested],
    splits: Sequence[Split],
    others: Sequence[Annotated],
    on_progress: OnProgress,
) -> dict[str, list[TestedCommand]]:
    """Parse all texts; a parser that learns does so from commands that aren't tested."""
    items = tested[AS_TYPED].items
    if others and not parser.learns:
        raise CorpusError(f"the parser {parser.name} doesn't learn", fix="leave --train out")
    learned: list[Any] = [parser.fit(others) if others else None] * len(items)
    for split in splits if parser.learns else ():
        value = parser.fit([items[i] for i in split.train])
        for i in split.test:
            learned[i] = value
    tasks = {
        kind: [
            ParseTask(item.command.text, value)
            for item, value in zip(own.items, learned, strict=True)
        ]
        for kind, own in tested.items()
    }
    parser.prepare([task for own in tasks.values() for task in own], on_progress)
    return {
        kind: [
            _compared(item, parser.parse(*task))
            for item, task in zip(own.items, tasks[kind], strict=True)
        ]
        for kind, own in tested.items()
    }


def _compared(item: Annotated, parse: Parse) -> TestedCommand:
    return TestedCommand(item, parse, compare(parse.sdcs, item.sdcs, item.command.text))


def _prepared(corpus: Corpus) -> _Tested:
    items = annotated_trees(corpus)
    return _Tested(items, prepare(items))


def _others(training: Corpus, tested: Sequence[Annotated]) -> list[Annotated]:
    """Return another corpus's commands to train on; no scenario may be tested."""
    items = annotated_trees(training)
    both = {i.command.scenario for i in items} & {i.command.scenario for i in tested}
    if both:
        raise CorpusError(
            f"the scenario {sorted(both)[0]!r} is in both corpora",
            where="--train",
            fix="use --corpus with --cv scenario alone, or corpora of different scenarios",
        )
    return items


def seen_scenarios(parser: SDCParser, items: Iterable[Annotated]) -> list[str]:
    """Return tested scenarios that the model was trained on; scores are too high there."""
    learned = parser.card_.get("scenarios", ())
    tested = {item.command.scenario for item in items}
    return sorted(tested & set(learned)) if isinstance(learned, (list, tuple)) else []


def _cross_validated(
    tested: Mapping[str, _Tested],
    splits: Sequence[Split],
    others: Sequence[Lesson],
    l2: float,
    on_progress: OnProgress,
) -> dict[str, list[TestedCommand]]:
    items, lessons = tested[AS_TYPED].items, tested[AS_TYPED].lessons
    result: dict[str, dict[int, TestedCommand]] = {kind: {} for kind in tested}
    for number, split in enumerate(splits):
        on_progress(f"without {split.name}", number, len(splits))
        taught = [lessons[i] for i in split.train]
        learned = SDCParser(l2=l2).fit(taught, others=others)
        for kind, own in tested.items():
            part = _Tested(*([one[i] for i in split.test] for one in (own.items, own.lessons)))
            result[kind] |= zip(split.test.tolist(), _parsed(learned, part), strict=True)
    return {kind: [own[i] for i in range(len(items))] for kind, own in result.items()}


def _parsed(parser: SDCParser, tested: _Tested) -> list[TestedCommand]:
    parses = parser.predict_proba([lesson.command for lesson in tested.lessons])
    return [_compared(item, parse) for item, parse in zip(tested.items, parses, strict=True)]


FIGURES = ("precision", "recall", "f")


def figures(tested: Sequence[TestedCommand]) -> dict[str, Any]:
    """Return the figures over all commands, by name."""
    comparisons = [one.comparison for one in tested]
    typed = sum((c.typed for c in comparisons), Counts())
    untyped = sum((c.untyped for c in comparisons), Counts())
    segments = sum((c.segments for c in comparisons), Counts())
    by_type = {type_: sum((c.by_type[type_] for c in comparisons), Counts()) for type_ in SDC_TYPES}
    result: dict[str, Any] = {}
    for name, counts in (("typed", typed), ("untyped", untyped), ("segmentation", segments)):
        result |= named({f"{name}_{figure}": getattr(counts, figure) for figure in FIGURES})
    exact = part(sum(c.exact for c in comparisons), len(comparisons), "no data")
    return result | {
        **named({"exact": exact}),
        "commands": len(comparisons),
        "unparsed": sum(not one.parse.trees and bool(one.parse.note) for one in tested),
        "constituents": typed.gold,
        "types": {
            type_: named({figure: getattr(counts, figure) for figure in FIGURES})
            | {"n": counts.gold}
            for type_, counts in by_type.items()
        },
    }


def confusion(tested: Sequence[TestedCommand]) -> dict[str, dict[str, int]]:
    """Count letters by annotated and by predicted type and field."""
    total: Counter[tuple[str, str]] = sum((t.comparison.confusion for t in tested), Counter())
    return {
        gold: {to: total[gold, to] for to in (*FIELDS, NOWHERE) if total[gold, to]}
        for gold in (*FIELDS, NOWHERE)
        if any(total[gold, to] for to in (*FIELDS, NOWHERE))
    }


def errors(tested: Sequence[TestedCommand]) -> list[dict[str, object]]:
    """List the commands with inexact trees, those that share least first."""

    def order(one: TestedCommand) -> tuple[float, str]:
        # Trees without words on either side have no F, and nothing in common.
        result = one.comparison.typed.f
        return result.value if result.is_known else 0.0, one.annotated.command.id

    wrong = sorted((one for one in tested if not one.comparison.exact), key=order)
    return [
        {
            "command": one.annotated.command.id,
            "text": one.annotated.command.text,
            **named({"typed_f": one.comparison.typed.f}),
            "gold": format_brackets(one.annotated.sdcs),
            "predicted": format_brackets(one.parse.sdcs),
            "note": one.parse.note,
        }
        for one in wrong
    ]


def render(
    by_kind: Mapping[str, Sequence[TestedCommand]],
    form: Literal["text", "json"],
    metadata: Mapping[str, object],
    *,
    top: int,
    terminal: bool,
) -> str:
    """Render all figures of the tested commands.

    Parameters
    ----------
    by_kind
        The tested commands as typed, and by perturbation.
    top
        Number of errors in a table; JSON has all.
    """
    tested = by_kind[AS_TYPED]
    result = figures(tested)
    wrong = errors(tested)
    perturbed = {kind: figures(own) for kind, own in by_kind.items() if kind != AS_TYPED}
    if form == "json":
        content = {**result, "confusion": confusion(tested), "errors": wrong}
        content |= {"perturbed": perturbed} if perturbed else {}
        return document(content, metadata)
    tables = {
        "Extraction of SDCs from text": _figures_table(result),
        **(
            {"The same commands perturbed": _perturbed_table(result, perturbed)}
            if perturbed
            else {}
        ),
        "Letters by annotated (rows) and extracted type and field": _confusion_table(tested),
        f"Worst errors ({min(top, len(wrong))} of {len(wrong)})": _errors_table(wrong[:top]),
    }
    records = (result, *result["types"].values(), *perturbed.values())
    reasons = explained(field for record in records for field in record.values())
    notes = [f"exact trees: {_shown(result, 'exact')} of {result['commands']} commands", *reasons]
    if result["unparsed"]:
        notes.append(f"not parsed: {result['unparsed']} commands")
    return table_text(tables, notes, metadata, terminal=terminal)


def _figures_table(record: Mapping[str, Any]) -> Table:
    table = figure_table(("", "Precision", "Recall", "F-score"))
    for name in ("typed", "untyped", "segmentation"):
        cells = (_shown(record, f"{name}_{figure}") for figure in FIGURES)
        table.add_row(name.capitalize(), *cells)
    for type_, of_type in record["types"].items():
        table.add_row(type_, *(_shown(of_type, figure) for figure in FIGURES))
    return table


def _shown(record: Mapping[str, Any], name: str) -> str:
    """Return a figure of a record, or the reason for its absence."""
    return str(record[f"{name}_reason"]) or f"{record[name]:.3f}"


def _perturbed_table(
    record: Mapping[str, object], perturbed: Mapping[str, Mapping[str, object]]
) -> Table:
    names = ("typed_f", "untyped_f", "segmentation_f", "exact")
    rows = (
        (kind, *(_shown(own, name) for name in names))
        for kind, own in {"as typed": record, **perturbed}.items()
    )
    return figure_table(("", *(name.removesuffix("_f").capitalize() for name in names)), rows)


def _confusion_table(tested: Sequence[TestedCommand]) -> Table:
    rows = confusion(tested)
    columns = [name for name in (*FIELDS, NOWHERE) if any(name in row for row in rows.values())]
    cells = ((name, *(str(row.get(c, "")) for c in columns)) for name, row in rows.items())
    return figure_table(("", *columns), cells)


def _errors_table(wrong: Sequence[Mapping[str, object]]) -> Table:
    table = Table(show_header=False)
    for error in wrong:
        table.add_row(cell(error["command"]), cell(error["text"]))
        for name in ("gold", "predicted"):
            for line in split_lines(str(error[name])):
                table.add_row(name, cell(line))
        if error["note"]:
            table.add_row("note", cell(error["note"]))
        table.add_row("", "")
    return table
