"""Making corpora, and from a corpus in memory to the records of its files."""

from __future__ import annotations

import hashlib
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import TypeVar

import msgspec

from corpus_tools.corpus import corpus_records as records
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.trajectory_arrays import Arrays, pack
from g3.annotation import Annotation, Command, Judgment, TaskOutcome
from g3.errors import CorpusError
from g3.groundings import Context, Grounding, PhysicalObject, Place, Prism, Trajectory
from g3.sdc.clauses import SDC, Span
from g3.short_repr import short_repr

R = TypeVar("R", records.CommandRecord, records.JudgmentRecord, records.OutcomeRecord)
Thing = TypeVar("Thing", records.ObjectRecord, records.ObjectGrounding)


@short_repr
@dataclass(frozen=True, slots=True)
class Tables:
    """The records of a corpus, file by file."""

    contexts: Sequence[records.ContextRecord]
    commands: Sequence[records.CommandRecord]
    annotations: Sequence[records.AnnotationRecord]
    judgments: Sequence[records.JudgmentRecord]
    trajectories: Arrays
    outcomes: Sequence[records.OutcomeRecord] = ()

    def counts(self) -> records.Counts:
        """Count the records of each file."""
        return records.Counts(
            contexts=len(self.contexts),
            commands=len(self.commands),
            annotations=len(self.annotations),
            judgments=len(self.judgments),
            trajectories=len(self.trajectories["offsets"]) - 1,
            outcomes=len(self.outcomes),
        )

    def lines(self) -> dict[str, bytes]:
        """Return each JSONL file's content by its name; without outcomes, no file of them."""
        tables: dict[str, Sequence[msgspec.Struct]] = {
            records.CONTEXTS: self.contexts,
            records.COMMANDS: self.commands,
            records.ANNOTATIONS: self.annotations,
            records.JUDGMENTS: self.judgments,
        }
        if self.outcomes:
            tables[records.OUTCOMES] = self.outcomes
        encoder = msgspec.json.Encoder()
        return {name: encoder.encode_lines(rows) for name, rows in tables.items()}


def make_corpus(
    name: str,
    *,
    contexts: Iterable[Context],
    commands: Iterable[Command],
    annotations: Iterable[Annotation],
    judgments: Iterable[Judgment] = (),
    outcomes: Iterable[TaskOutcome] = (),
    source: str = "",
    licence: str = "",
) -> Corpus:
    """Put a corpus together and compute its hash."""
    corpus = Corpus(
        name=name,
        contexts={context.id: context for context in contexts},
        commands={command.id: command for command in commands},
        annotations=tuple(annotations),
        judgments=tuple(judgments),
        source=source,
        licence=licence,
        hash="",
        outcomes=tuple(outcomes),
    )
    return rehashed(corpus)


def rehashed(corpus: Corpus) -> Corpus:
    """Return the corpus with the hash of its content, for one that was changed by ``replace``."""
    return replace(corpus, hash=content_hash(encode(corpus)))


def content_hash(tables: Tables) -> str:
    """``sha256:`` and the digest of all records and poses, with the subjects left out."""
    digest = hashlib.sha256()
    anonymous = replace(
        tables,
        commands=[msgspec.structs.replace(r, subject="") for r in tables.commands],
        judgments=[msgspec.structs.replace(r, subject="") for r in tables.judgments],
    )
    for lines in anonymous.lines().values():
        digest.update(lines)
        digest.update(b"\n")
    for name, array in tables.trajectories.items():
        digest.update(f"{name} {array.shape}\n".encode())
        digest.update(array.tobytes())
    return f"sha256:{digest.hexdigest()}"


_Homes = dict[str, dict[str, PhysicalObject]]
"""Objects by id and by the context that they are in."""


class _Trajectories:
    """Gives each different trajectory a number, in the order of first use."""

    def __init__(self) -> None:
        self.unique: list[Trajectory] = []
        self._numbers: dict[tuple[bytes, bytes, bytes], int] = {}

    def number(self, trajectory: Trajectory) -> int:
        key = (trajectory.t.tobytes(), trajectory.xyz.tobytes(), trajectory.yaw.tobytes())
        number = self._numbers.setdefault(key, len(self.unique))
        if number == len(self.unique):
            self.unique.append(trajectory)
        return number


def encode(corpus: Corpus) -> Tables:
    """Convert a corpus to its records."""
    trajectories = _Trajectories()
    homes: _Homes = defaultdict(dict)
    for context in corpus.contexts.values():
        for item in context.objects:
            homes[item.id][context.id] = item
    return Tables(
        contexts=[_context(context, trajectories) for context in corpus.contexts.values()],
        commands=_alike(records.CommandRecord, corpus.commands.values()),
        annotations=[_annotation(a, homes, trajectories) for a in corpus.annotations],
        judgments=_alike(records.JudgmentRecord, corpus.judgments),
        trajectories=pack(trajectories.unique),
        outcomes=_alike(records.OutcomeRecord, corpus.outcomes),
    )


def _alike(kind: type[R], things: Iterable[object]) -> list[R]:
    """Make records of things that have the same fields; empty ones are the records' defaults."""
    rows = (
        {name: value for name in kind.__struct_fields__ if (value := getattr(thing, name)) != ()}
        for thing in things
    )
    return [kind(**row) for row in rows]


def _context(context: Context, trajectories: _Trajectories) -> records.ContextRecord:
    return records.ContextRecord(
        id=context.id,
        agent_id=context.agent_id,
        objects=tuple(_object(records.ObjectRecord, o, trajectories) for o in context.objects),
        places=tuple(
            records.PlaceRecord(_prism(place.prism), place.name) for place in context.places
        ),
        assumed=context.assumed or (),
    )


def _annotation(
    annotation: Annotation,
    homes: _Homes,
    trajectories: _Trajectories,
) -> records.AnnotationRecord:
    here = annotation.context.id
    return records.AnnotationRecord(
        id=annotation.id,
        command=annotation.command.id,
        context=here,
        source=annotation.source,
        sdcs=tuple(_sdc(sdc) for sdc in annotation.sdcs),
        groundings=tuple(
            tuple(_grounding(grounding, here, homes, trajectories) for grounding in groundings)
            for groundings in annotation.groundings
        ),
        correct=annotation.correct,
    )


def _grounding(
    grounding: Grounding,
    here: str,
    homes: _Homes,
    trajectories: _Trajectories,
) -> records.GroundingRecord:
    if isinstance(grounding, Place):
        return records.PlaceGrounding(_prism(grounding.prism), grounding.name)
    if not isinstance(grounding, PhysicalObject):
        return records.PathGrounding(trajectories.number(grounding.trajectory))
    known = homes[grounding.id]
    if here in known and (known[here] is grounding or known[here] == grounding):
        return records.ObjectReference(grounding.id)
    for context, item in known.items():
        if item == grounding:
            return records.ObjectReference(grounding.id, context)
    return _object(records.ObjectGrounding, grounding, trajectories)


def _object(kind: type[Thing], o: PhysicalObject, trajectories: _Trajectories) -> Thing:
    number = trajectories.number(o.trajectory)
    return kind(o.id, o.labels, _prism(o.prism), number, o.liftable, o.colours)


def _prism(prism: Prism) -> records.PrismRecord:
    corners = tuple((x, y) for x, y in prism.xy.tolist())
    return records.PrismRecord(corners, float(prism.z_min), float(prism.z_max))


def _words(spans: Iterable[Span]) -> tuple[tuple[int, str], ...]:
    return tuple((span.start, span.text) for span in spans) or ()


def _sdc(sdc: SDC) -> records.SDCRecord:
    return records.SDCRecord(
        type=sdc.type,
        words=_words(sdc.words),
        relation=_words(sdc.relation),
        figure=_sdcs(sdc.figure),
        landmark1=_sdcs(sdc.landmark1),
        landmark2=_sdcs(sdc.landmark2),
    )


def _sdcs(sdcs: Sequence[SDC]) -> tuple[records.SDCRecord, ...]:
    # The one empty tuple that the default is: Python 3.10 makes others of empty generators, and
    # msgspec leaves out only what is the default itself.
    return tuple(_sdc(child) for child in sdcs) or ()


def merged(name: str, corpora: Sequence[Corpus]) -> Corpus:
    """Put all that corpora hold into one, in their order; CorpusError if two have the same id."""
    for what, ids in {
        "context": chain.from_iterable(c.contexts for c in corpora),
        "command": chain.from_iterable(c.commands for c in corpora),
        "annotation": (a.id for c in corpora for a in c.annotations),
        "judgment": (j.id for c in corpora for j in c.judgments),
        "outcome": (o.id for c in corpora for o in c.outcomes),
    }.items():
        twice = next((name for name, count in Counter(ids).items() if count > 1), "")
        if twice:
            raise CorpusError(
                f"two of the corpora have the {what} {twice!r}",
                where=name,
                fix="rename it in one of them",
            )
    return make_corpus(
        name,
        contexts=chain.from_iterable(c.contexts.values() for c in corpora),
        commands=chain.from_iterable(c.commands.values() for c in corpora),
        annotations=chain.from_iterable(c.annotations for c in corpora),
        judgments=chain.from_iterable(c.judgments for c in corpora),
        outcomes=chain.from_iterable(c.outcomes for c in corpora),
        source="; ".join(dict.fromkeys(c.source for c in corpora)),
        licence="; ".join(dict.fromkeys(c.licence for c in corpora)),
    )
