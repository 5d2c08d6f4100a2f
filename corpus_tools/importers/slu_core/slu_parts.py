"""The parts of the authors' release: which are there, and importing one or all of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import Literal, TypeAlias, get_args

import msgspec

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.start_headings import parse_heading
from corpus_tools.importers.report import ImportReport
from corpus_tools.importers.slu_core.automatic_corpus import (
    OBJECTS,
    STATUS,
    WorldFolders,
    import_automatic,
)
from corpus_tools.importers.slu_core.slu_corpus import import_slu_core
from corpus_tools.importers.slu_core.slu_files import (
    COMPRESSED,
    IMPORTER,
    SCENARIOS,
    find_layout,
)
from corpus_tools.importers.slu_core.spatial_relations import RelationFiles, import_relations
from corpus_tools.runtime.progress import OnProgress, no_progress
from g3.errors import FormatError

Part: TypeAlias = Literal["aaai11", "automatic", "spatial-relations"]
PARTS: tuple[Part, ...] = get_args(Part)
ALL = "all"
AUTOMATIC = "automatic"
"""Part of the names of folders with random tasks."""
RELATIONS, RELATION_FILES = "spatial_relations", "spatialRelations*.yaml"
"""The folder of phrases of paths; how its files are called where they lie elsewhere."""


def import_parts(
    path: Path,
    *,
    salt: str,
    keep_going: bool = False,
    on_progress: OnProgress = no_progress,
    part: str = "aaai11",
    heading: str = "loads",
) -> tuple[Corpus, ImportReport]:
    """Import a part of the release, or all of it that is there as one corpus.

    See :class:`corpus_tools.importers.importer_registry.ImportFunction`. `path` is a clone of
    h2r/slu_core, its data folder, or a folder with some of the parts; `part` one of `PARTS`, or
    `ALL`; `heading` which way the robot of random tasks faces
    (:func:`corpus_tools.corpus.start_headings.parse_heading`). FormatError if the part isn't there,
    or something in it can't be read.
    """
    rule = parse_heading(heading)
    worlds, relations = find_automatic(path), find_relations(path)
    importers: Mapping[Part, Callable[[], tuple[Corpus, ImportReport]]] = {
        "aaai11": lambda: import_slu_core(
            path, salt=salt, keep_going=keep_going, on_progress=on_progress
        ),
        "automatic": lambda: import_automatic(
            worlds, salt=salt, heading=rule, keep_going=keep_going, on_progress=on_progress
        ),
        "spatial-relations": lambda: import_relations(
            relations, keep_going=keep_going, on_progress=on_progress
        ),
    }
    there = tuple(_parts_there(path, worlds, relations))
    taken = there if part == ALL else (part,)
    if part not in there and there and part != ALL:
        raise FormatError(
            f"the part {part} is not there; {', '.join(there)} is",
            where=str(path),
            fix=f"import it with --part {there[0]}, or give a clone of h2r/slu_core",
        )
    if not there:
        find_layout(path)  # tells what is looked for
    done = [importers[name]() for name in PARTS if name in taken]
    reports = [report for _, report in done]
    corpus = done[0][0] if len(done) == 1 else Corpus.merge(IMPORTER, [c for c, _ in done])
    return corpus, msgspec.structs.replace(
        _joined(reports), parts_there=there, parts_taken=tuple(p for p in PARTS if p in taken)
    )


def find_automatic(path: Path) -> WorldFolders:
    """Find the folders of random tasks: in a clone, beside each other, or in `path` itself."""
    path = path.resolve()
    for data in (path / SCENARIOS, path / "data" / SCENARIOS, path):
        groups = [folder for folder in _folders(data) if _is_group(folder)]
        worlds = [world for group in groups for world in _folders(group)]
        if worlds:
            base = data if data == path else data.parent
            return WorldFolders(base, tuple(world.relative_to(base).as_posix() for world in worlds))
    worlds = list(_folders(path)) if _is_group(path) else []
    return WorldFolders(path, tuple(world.name for world in worlds))


def find_relations(path: Path) -> RelationFiles:
    """Find the files with phrases of paths: in a clone, or in `path` itself."""
    path = path.resolve()
    for data, pattern in (
        (path, f"{RELATIONS}/*.yaml"),
        (path / "data", f"{RELATIONS}/*.yaml"),
        (path, RELATION_FILES),
    ):
        files = chain(data.glob(pattern), data.glob(pattern + COMPRESSED))
        names = {file.relative_to(data).as_posix().removesuffix(COMPRESSED) for file in files}
        if names:
            return RelationFiles(data, tuple(sorted(names)))
    return RelationFiles(path, ())


def _folders(path: Path) -> Iterator[Path]:
    if path.is_dir():
        yield from sorted(p for p in path.iterdir() if p.is_dir() and not p.name.startswith("."))


def _is_group(folder: Path) -> bool:
    """Check that a folder holds folders of videos, of which at least one is of a random task."""
    inner = list(_folders(folder))
    has_log = any((world / STATUS).is_file() for world in inner)
    has_world = any((world / OBJECTS).is_file() for world in inner)
    return has_log or (has_world and AUTOMATIC in folder.name)


def _parts_there(path: Path, worlds: WorldFolders, relations: RelationFiles) -> Iterator[Part]:
    try:
        find_layout(path)
    except FormatError:
        pass
    else:
        yield "aaai11"
    if worlds.folders:
        yield "automatic"
    if relations.names:
        yield "spatial-relations"


def _joined(reports: list[ImportReport]) -> ImportReport:
    if len(reports) == 1:
        return reports[0]

    def numbers(name: str) -> dict[str, int]:
        joined: dict[str, int] = {}
        for report in reports:
            for key, count in getattr(report, name).items():
                joined[key] = joined.get(key, 0) + count
        return joined

    return ImportReport(
        importer=IMPORTER,
        counts=numbers("counts"),
        skipped=tuple(chain.from_iterable(r.skipped for r in reports)),
        notes=tuple(chain.from_iterable(r.notes for r in reports)),
        not_imported=numbers("not_imported"),
        missing=tuple(chain.from_iterable(r.missing for r in reports)),
        files=tuple(chain.from_iterable(r.files for r in reports)),
    )
