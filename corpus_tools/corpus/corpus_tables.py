"""The records of a corpus, file by file: encoding, hash and digests.

The digests of corpus.json are over the records, not over the bytes: other line ends or another
indentation change nothing, and every other change is found.
"""

from __future__ import annotations

import hashlib
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import numpy as np
import numpy.typing as npt

from corpus_tools.corpus import corpus_records as records
from corpus_tools.corpus.corpus_records import TRAJECTORIES
from g3.annotation import Annotation, Command, Judgment, TaskOutcome
from g3.errors import FormatError
from g3.groundings import Context, Grounding, PhysicalObject, Place, Prism, Trajectory
from g3.sdc.clauses import SDC, Span
from g3.short_repr import short_repr
from g3.storage import array_file
from g3.storage.array_file import Field

Arrays = dict[str, npt.NDArray[Any]]
_FIELDS = {
    "offsets": Field("<i8"),
    "t": Field("<f8"),
    "xyz": Field("<f8", dimensions=2),
    "yaw": Field("<f8"),
}
"""Arrays of trajectories.npz, which has every trajectory once, end to end. ``t`` (n,), ``xyz``
(n, 3) and ``yaw`` (n,) hold all poses; those of trajectory i begin at ``offsets[i]`` and end before
``offsets[i + 1]``."""


def pack(trajectories: Sequence[Trajectory]) -> Arrays:
    """Lay trajectories end to end."""
    lengths = [len(trajectory) for trajectory in trajectories]
    return {
        "offsets": np.cumsum([0, *lengths], dtype="<i8"),
        "t": np.concatenate([np.empty(0), *(x.t for x in trajectories)]).astype("<f8"),
        "xyz": np.concatenate([np.empty((0, 3)), *(x.xyz for x in trajectories)]).astype("<f8"),
        "yaw": np.concatenate([np.empty(0), *(x.yaw for x in trajectories)]).astype("<f8"),
    }


def to_bytes(arrays: Arrays) -> bytes:
    """Return the file's bytes, the same for the same arrays."""
    return array_file.write_arrays({name: arrays[name] for name in _FIELDS}, compressed=False)


def read_arrays(path: Path) -> Arrays:
    """Read the file; FormatError if it is missing, cut off or doesn't hold the four arrays."""
    fix = "restore the file, or import the corpus again"
    if not path.is_file():
        raise FormatError("the file is missing", where=str(path), fix=fix)
    arrays = array_file.read_arrays(path, _FIELDS, where=str(path), fix=fix, error=FormatError)
    offsets, t, xyz, yaw = (arrays[name] for name in _FIELDS)
    n = len(t)
    if not len(offsets) or xyz.shape != (n, 3) or yaw.shape != (n,):
        raise FormatError(
            "the arrays' shapes don't fit: offsets (k,), t (n,), xyz (n, 3) and yaw (n,) "
            "are expected",
            where=str(path),
            fix=fix,
        )
    if offsets[0] != 0 or offsets[-1] != n or (np.diff(offsets) < 0).any():
        raise FormatError("offsets don't divide the poses", where=f"{path}: offsets", fix=fix)
    return arrays


def as_lists(arrays: Arrays) -> Iterator[dict[str, Any]]:
    """Yield the poses of each trajectory as lists, by the names of the arrays."""
    for start, end in pairwise(arrays["offsets"].tolist()):
        yield {name: arrays[name][start:end].tolist() for name in ("t", "xyz", "yaw")}


def unpack_one(arrays: Arrays, index: int) -> Trajectory:
    """Trajectory number `index`; FormatError if it has no poses, isn't finite or runs backwards."""
    start, end = arrays["offsets"][index : index + 2]
    try:
        return Trajectory(
            t=arrays["t"][start:end], xyz=arrays["xyz"][start:end], yaw=arrays["yaw"][start:end]
        )
    except ValueError as error:
        raise FormatError(
            str(error),
            where=f"{TRAJECTORIES}: trajectory {index}",
            fix="restore the file, or correct the values",
        ) from error


R = TypeVar("R", records.CommandRecord, records.JudgmentRecord, records.OutcomeRecord)
Thing = TypeVar("Thing", records.ObjectRecord, records.ObjectGrounding)


@short_repr
@dataclass(frozen=True, slots=True)
class Content:
    """Everything that is stored of a corpus beside its name and its origin."""

    contexts: Mapping[str, Context]
    commands: Mapping[str, Command]
    annotations: tuple[Annotation, ...]
    judgments: tuple[Judgment, ...] = ()
    outcomes: tuple[TaskOutcome, ...] = ()


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


def encode(corpus: Content) -> Tables:
    """Convert the content of a corpus to its records."""
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
        taken_back=_words(annotation.taken_back),
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
    contexts = homes[grounding.id]
    if here in contexts and (contexts[here] is grounding or contexts[here] == grounding):
        return records.ObjectReference(grounding.id)
    for context, item in contexts.items():
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


def sealed(manifest: records.Manifest, tables: Tables) -> records.Manifest:
    """Return a manifest with the hash, the counts and the digests of the tables."""
    counted = msgspec.structs.replace(
        manifest,
        schema_version=records.SCHEMA_VERSION,
        hash=content_hash(tables),
        counts=tables.counts(),
    )
    return msgspec.structs.replace(counted, digests=_digests(counted, tables))


def problems(manifest: records.Manifest, tables: Tables, folder: str) -> Iterator[FormatError]:
    """Yield an error for each difference between corpus and manifest; errors name `folder`."""
    file, accept = records.MANIFEST, f"accept the change with: ct corpus seal {folder}"
    counted = msgspec.structs.asdict(tables.counts())
    for name, promised in msgspec.structs.asdict(manifest.counts).items():
        if counted[name] != promised:
            yield FormatError(
                f"{promised} {name} are promised, {counted[name]} are there",
                where=f"{folder}/{records.MANIFEST}: counts.{name}",
                fix=f"restore the file, or {accept}",
            )
    expected = (
        _digests(manifest, tables) if manifest.schema_version == records.SCHEMA_VERSION else {}
    )
    for name in sorted(expected.keys() | manifest.digests.keys()):
        if manifest.digests.get(name) != expected.get(name):
            yield FormatError(
                f"the content is not what was written: its digest differs from {file}'s",
                where=f"{folder}/{name}",
                fix=f"restore the file, or {accept}",
            )
    if manifest.hash != content_hash(tables):
        yield FormatError(
            "the content is not what was written: its hash differs",
            where=f"{folder}/{records.MANIFEST}: hash",
            fix=f"restore the files, or {accept}",
        )


def is_as_written(manifest: records.Manifest, found: Mapping[str, str], arrays: Arrays) -> bool:
    """Check that files are byte by byte those that a manifest was written with.

    `found` has for the name of each JSONL file the digest of its bytes.
    """
    whole = {records.MANIFEST: _of_manifest(manifest), records.TRAJECTORIES: _of_arrays(arrays)}
    digests = {**found, **{name: _digest(parts) for name, parts in whole.items()}}
    return manifest.schema_version == records.SCHEMA_VERSION and manifest.digests == digests


def _of_manifest(manifest: records.Manifest) -> list[bytes]:
    return [msgspec.json.encode(msgspec.structs.replace(manifest, digests={}))]


def _of_arrays(arrays: Arrays) -> list[bytes]:
    return [
        part
        for name, array in arrays.items()
        for part in (f"{name} {array.shape}\n".encode(), array.tobytes())
    ]


def _digests(manifest: records.Manifest, tables: Tables) -> dict[str, str]:
    contents = {
        records.MANIFEST: _of_manifest(manifest),
        **{name: [content] for name, content in tables.lines().items()},
        records.TRAJECTORIES: _of_arrays(tables.trajectories),
    }
    return {name: _digest(parts) for name, parts in contents.items()}


def _digest(parts: list[bytes]) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    return f"sha256:{digest.hexdigest()}"


def files(name: str, source: str, licence: str, content: Content) -> dict[str, bytes]:
    """Return the contents of a corpus's files by their names, the same for the same corpus."""
    tables = encode(content)
    manifest = records.Manifest(
        schema_version=records.SCHEMA_VERSION,
        name=name,
        source=source,
        licence=licence,
        hash="",
        counts=tables.counts(),
    )
    return {
        records.MANIFEST: manifest_to_bytes(sealed(manifest, tables)),
        **tables.lines(),
        records.TRAJECTORIES: to_bytes(tables.trajectories),
    }


def manifest_to_bytes(manifest: records.Manifest) -> bytes:
    """Return the content of corpus.json."""
    return msgspec.json.format(msgspec.json.encode(manifest), indent=2) + b"\n"
