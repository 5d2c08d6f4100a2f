"""Segment: people mark the clauses of a command and how they belong together.

An item's payload is ``{"video", "text", "command": id of the answer}``, and ``"suggestion"``: SDCs,
if the command came with some. In a study of a corpus's texts alone it has ``"corrects": True``:
people correct what the corpus has, and a command may ask for nothing.

The page sends ``{"sdcs"}`` as :func:`g3.sdc.sdc_notation.to_json` writes them. A segmentation is
adopted when it is the only one that is asked for, or all that were asked for agree; else an
adjudicator adopts one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import IO, Any, NamedTuple

import msgspec
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_, SOURCE, gettext
from annotation_app.core.problems import FieldProblem
from annotation_app.items.assignment import AnyItem
from annotation_app.items.item_scenes import watched
from annotation_app.items.new_items import NewItem
from annotation_app.store.models import Answer, Item, Record, Study
from annotation_app.studies.study_file import StudyConfig, language_of
from annotation_app.studies.suggestions import certainty, suggest, warm_up
from annotation_app.tasks.agreement import Part, f_score, mean_of_pairs, nodes, spans, tree_f
from annotation_app.tasks.clause_words import words_of
from annotation_app.tasks.corpus_parts import CorpusParts, answers_of
from annotation_app.tasks.practice_example import OwnPractice
from annotation_app.tasks.task_record import (
    CLAUSES,
    COMMAND,
    EDITOR_KEYS,
    Adjudication,
    AnswerTable,
    Compared,
    Counts,
    Source,
    Suggestion,
    Task,
    TaskWords,
)
from annotation_app.tasks.tree_differences import MarkedClause, disputed_parts, marked
from corpus_tools.corpus.corpus_entries import Entry
from corpus_tools.importers.treebank import robot_alone
from g3.annotation import Annotation, Command
from g3.errors import SDCError
from g3.groundings import Context
from g3.sdc.clauses import CHILD_FIELDS, SDC, SDC_TYPES, Span, all_words, breadth_first
from g3.sdc.sdc_drawing import to_svg
from g3.sdc.sdc_notation import format_brackets, from_json, to_json


class Segmented(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The SDC trees of a command."""

    sdcs: list[dict[str, Any]]


@dataclass(frozen=True, slots=True)
class TreeCounts:
    """Counts of adopted trees, and of their clauses of each type."""

    trees: int
    clauses: dict[str, int]


@dataclass(frozen=True, slots=True)
class ShownTrees:
    """The clauses of an answer as text and as SVG, with what differs in other answers marked."""

    notation: str
    drawing: str
    clauses: tuple[MarkedClause, ...]


def segmentation_problems(sdcs: tuple[SDC, ...], text: str) -> Iterator[FieldProblem]:
    """Yield the faults of a command's SDC trees, beyond their form."""
    if all(sdc.is_implicit for sdc in breadth_first(sdcs)):
        yield FieldProblem("sdcs", gettext("Mark at least one clause."))
    for i, tree in enumerate(sdcs):
        words = all_words(tree)
        for word in words:
            if text[word.start : word.end] != word.text:
                told = gettext("“%(word)s” is not in the command there.", word=word.text)
                yield FieldProblem(f"sdcs[{i}]", told)
        for word in sorted({w for w, following in pairwise(words) if w == following}):
            told = gettext(
                "The word “%(word)s” is used twice. Use it in one place.", word=word.text
            )
            yield FieldProblem(f"sdcs[{i}]", told)
    for node, sdc in enumerate(breadth_first(sdcs)):
        is_figure = any(sdc is figure for parent in breadth_first(sdcs) for figure in parent.figure)
        if sdc.is_implicit and not (sdc.type == "OBJECT" and is_figure):
            told = gettext("This clause has no words. Give it some, or remove it.")
            yield FieldProblem(str(node), told)


def _suggestion(_session: Session, item: Item) -> Suggestion | None:
    given = item.payload.get("suggestion")
    if given or (item.payload.get("corrects") and given is not None):
        return Suggestion(given)
    found = suggest(item.payload["text"])
    return Suggestion(*found) if found is not None else None


def _likeness(suggestion: Any, body: Record) -> float:
    return tree_f(from_json(suggestion), from_json(body["sdcs"]))


def _payload(session: Session, item: Item, _salt: bytes) -> Record:
    text = item.payload["text"]
    shown = {"command": text, "words": list(words_of(text)), **watched(session, item)}
    return {
        **shown,
        "corrects": bool(item.payload.get("corrects")),
        **_certainty(session, item, shown["words"]),
    }


def _certainty(session: Session, item: Item, words: Sequence[Record]) -> Record:
    """Return the numbers of words that a program is sure or unsure of, if it knows the language."""
    config = session.get_one(Study, item.study_id).config
    if language_of(config).split("-")[0] != SOURCE:
        return {}
    text = item.payload["text"]
    sure = certainty(text)
    unsure = frozenset() if "suggestion" in item.payload else sure.unsure
    named = {"actions": sure.actions, "things": sure.things, "wheres": sure.wheres}
    return {
        name: [i for i, word in enumerate(words) if word["start"] in starts and _has_letters(word)]
        for name, starts in {**named, "unsure": unsure}.items()
    }


def _has_letters(word: Record) -> bool:
    return any(map(str.isalnum, word["text"]))


def _check(
    _session: Session, item: AnyItem, answer: Segmented, _salt: bytes
) -> tuple[Record, list[FieldProblem]]:
    try:
        sdcs = from_json(answer.sdcs)
    except SDCError as error:
        message = f"{error.what[:1].upper()}{error.what[1:]}."
        why = f"{message} {error.fix}".strip()
        problem = gettext("The clauses can't be read: %(why)s", why=why)
        return {}, [FieldProblem(error.where, problem)]
    if not sdcs and item.payload.get("corrects"):
        return {"sdcs": []}, []
    return {"sdcs": to_json(sdcs)}, [*segmentation_problems(sdcs, item.payload["text"])]


def _export(parts: CorpusParts) -> None:
    """Add the trees of commands without a world; those of a corpus that stay are as they were."""
    corpus = () if parts.original is None or parts.worlds else parts.original
    entries = {entry.id: entry for entry in corpus}
    adopted = {
        item.payload["command"]: from_json(answer.body["sdcs"])
        for answer, item in answers_of(parts.session, parts.study, "segment", adopted=True)
        if item.payload["video"] not in parts.worlds
    }
    alone = robot_alone(parts.study.name)
    for answer, command in parts.commands.items():
        entry = entries.get(command.id, Entry(command))
        given = tuple(replace(one, command=command) for one in entry.annotations)
        sdcs = adopted.get(answer)
        if sdcs is None or (given and _same_letters(sdcs, entry.sdcs, command.text)):
            parts.annotations += given
        else:
            whole = tuple(_whole_words(sdc, command.text) for sdc in sdcs)
            kept = entry.annotation.taken_back if entry.annotation else ()
            parts.annotations.append(_ungrounded(command, entry.context or alone, whole, kept))


def _ungrounded(
    command: Command, context: Context, sdcs: tuple[SDC, ...], taken_back: tuple[Span, ...]
) -> Annotation:
    clauses = list(breadth_first(sdcs))
    placed = {word.start for sdc in sdcs for word in all_words(sdc)}
    return Annotation(
        id=f"{command.id}/positive",
        command=command,
        context=context,
        sdcs=sdcs,
        groundings=((),) * len(clauses),
        correct=(None,) * len(clauses),
        source="positive",
        taken_back=tuple(word for word in taken_back if word.start not in placed),
    )


def _same_letters(one: Sequence[SDC], other: Sequence[SDC], text: str) -> bool:
    """Compare trees however their words are cut: the page's words are other than a corpus's."""

    def shape(sdc: SDC) -> tuple[object, ...]:
        words = (
            tuple(i for w in field for i in range(w.start, w.end) if text[i].isalnum())
            for field in (sdc.words, sdc.relation)
        )
        children = (tuple(map(shape, sdc.children(name))) for name in CHILD_FIELDS)
        return (sdc.type, *words, *children)

    return tuple(map(shape, one)) == tuple(map(shape, other))


def _whole_words(sdc: SDC, text: str) -> SDC:
    """Join the page's words that no white space divides, such as those of "1.5"."""

    def joined(words: tuple[Span, ...]) -> tuple[Span, ...]:
        found: list[Span] = []
        for word in words:
            between = text[found[-1].end : word.start] if found else " "
            if not found or word.start < found[-1].end or any(map(str.isspace, between)):
                found.append(word)
            else:
                found[-1] = Span(found[-1].start, text[found[-1].start : word.end])
        return tuple(found)

    figure, landmark1, landmark2 = (
        tuple(_whole_words(child, text) for child in sdc.children(name)) for name in CHILD_FIELDS
    )
    return SDC(sdc.type, joined(sdc.words), joined(sdc.relation), figure, landmark1, landmark2)


def _items(
    _session: Session, _config: StudyConfig, item: Item, answer: Answer
) -> Iterable[NewItem]:
    about = {"text": answer.body["text"], "command": answer.id, "video": item.payload["video"]}
    yield NewItem("segment", f"command {answer.id}", about)


def _agreement(one: Record, other: Record) -> float:
    return tree_f(from_json(one["sdcs"]), from_json(other["sdcs"]))


def _compare(_session: Session, _item: Item, bodies: Sequence[Record], _salt: bytes) -> Compared:
    trees = [from_json(body["sdcs"]) for body in bodies]
    return Compared(
        tuple(
            ShownTrees(
                format_brackets(sdcs),
                to_svg(sdcs, [clause.number for clause in clauses if clause.differs]),
                clauses,
            )
            for sdcs, clauses in zip(trees, marked(trees), strict=True)
        )
    )


def _opened(data: Record, answer: Record) -> Record:
    """Return a page's data with an answer in place of the suggestion, as its first state."""
    return {**data, "payload": {**data["payload"], "suggestion": answer["sdcs"], "unsure": []}}


def _disputed(_item: Item, bodies: Sequence[Record]) -> Iterable[Part]:
    return disputed_parts([from_json(body["sdcs"]) for body in bodies])


def _counts(answers: Sequence[tuple[Record, bool]]) -> Any:
    trees = [_counted(msgspec.json.encode(body["sdcs"])) for body, adopted in answers if adopted]
    types: Counter[str] = Counter()
    for tree in trees:
        for (type_, _), count in tree.spans.items():
            types[type_] += count
    return TreeCounts(len(trees), {name: types[name] for name in SDC_TYPES})


class _Counted(NamedTuple):
    """The clauses of an answer, counted for measures of agreement."""

    spans: Counter[Any]
    nodes: Counter[Any]


@lru_cache(maxsize=4096)  # people often leave a suggestion as it is, and the dashboard looks again
def _counted(sdcs: bytes) -> _Counted:
    trees = from_json(msgspec.json.decode(sdcs))
    return _Counted(spans(trees), nodes(trees))


def _became_of(provenance: Record | None) -> str:
    """Return a suggestion's state and its likeness to the answer, for a comment."""
    if provenance is None:
        return "unknown"
    likeness = f", likeness {provenance['likeness']:.3f}" if "likeness" in provenance else ""
    return f"{provenance['suggestion']}{likeness}"


def to_conllu(session: Session, study: Study, file: IO[bytes]) -> None:
    """Write the adopted clauses with their words; FormatError without the English parser."""
    from g3.language.parsing.conllu import to_conllu as sentence  # noqa: PLC0415 - slow to import
    from g3.language.parsing.spacy_pipeline import analyse  # noqa: PLC0415 - as above

    found = session.execute(
        select(Answer, Item)
        .join(Item, Item.id == Answer.item_id)
        .where(Item.study_id == study.id, Item.task == "segment", Answer.adopted)
        .order_by(Answer.id)
    ).all()
    analyses = analyse(item.payload["text"] for _, item in found)
    sentences = (
        sentence(
            analysis,
            from_json(answer.body["sdcs"]),
            sent_id=f"{study.name}-{answer.id}",
            comments={"suggestion": _became_of(answer.provenance)},
        )
        for (answer, _), analysis in zip(found, analyses, strict=True)
    )
    file.writelines(f"{text}\n".encode() for text in sentences)


def _own_example(own: OwnPractice) -> Record:
    answer = own.item.answer
    return {
        "command": own.command,
        "words": list(words_of(own.command)),
        "suggestion": None,
        **own.watched(),
        "right": answer["sdcs"] if answer is not None else None,
    }


SEGMENT = Task(
    name="segment",
    words=TaskWords(
        title=N_("Segment"),
        summary=N_("Tell what belongs together in a command."),
        offer=N_("Tell what belongs together in short commands."),
        instructions=(
            N_(
                "First choose the words that say what to do, wherever they stand, and press “What "
                "to do?”. If there are none, as in “The cup on the table, please”, press “No word "
                "says it”."
            ),
            N_(
                "The next word is chosen for you then. If others belong with it, choose them too:"
                " “the cup”. Then choose the place that they answer: “Put what?”"
            ),
            N_(
                "“On”, “to”, “next to” and the like have places of their own. What follows them "
                "comes after: “on”, then “the table”."
            ),
            N_(
                "In “Take the cup on the table”, “on” tells which cup. Its place is “the cup: "
                "which one?”."
            ),
            N_("Words need not stand side by side: in “Put it down”, what to do is “Put … down”."),
        ),
        keys=(
            ("← →", N_("go from word to word")),
            (N_("Space"), N_("choose the word, or not")),
            (N_("Shift ← →"), N_("choose words in a row")),
            (N_("1 to 9"), N_("put the chosen words into the place with this number")),
            ("X", N_("leave the chosen words out")),
            ("[ ]", N_("go from part to part")),
            (N_("Delete"), N_("remove the part")),
            *EDITOR_KEYS,
        ),
    ),
    template="tasks/segment.html",
    answer=Segmented,
    payload=_payload,
    check=_check,
    example=lambda scene: {
        "command": scene.command,
        "words": scene.words,
        "suggestion": None,
        **scene.watched,
        "right": scene.sdcs,
    },
    own_example=_own_example,
    practises=("video", "command"),
    suggestion=_suggestion,
    suggested_from=0.8,
    suggested_from_why=(
        "Measured on 300 commands by imitated people whom the parser has not seen: of its 71 trees "
        "from 0.8 on 57 were right as a whole (from 0.5 on 84 of 122), of the 229 below 78."
    ),
    likeness=_likeness,
    warm_up=warm_up,
    facts=lambda _session, _item, body: [("", format_brackets(from_json(body["sdcs"])))],
    gives=CLAUSES,
    source=Source(COMMAND, _items),
    export=_export,
    adjudication=Adjudication(
        essence=lambda body: body,
        agreement=_agreement,
        compare=_compare,
        opened=_opened,
        template="dashboard/compare_trees.html",
    ),
    counts=Counts(
        TreeCounts, _counts, {"trees": "adopted SDC trees"}, "dashboard/clause_counts.html"
    ),
    agreement=(
        mean_of_pairs(
            {
                "span F": lambda one, other: f_score(one.spans, other.spans),
                "tree F": lambda one, other: f_score(one.nodes, other.nodes),
            },
            lambda body: _counted(msgspec.json.encode(body["sdcs"])),
        ),
    ),
    disputed=_disputed,
    tables={
        "conllu": AnswerTable(
            "Clauses (CoNLL-U)",
            "text/plain; charset=utf-8",
            to_conllu,
            "the words of each command, with their clauses and a parse",
        )
    },
)
