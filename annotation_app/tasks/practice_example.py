"""The app's practice examples: a made-up scene at sea, which suggests no words for commands."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import msgspec

from annotation_app.core.languages import N_, gettext
from annotation_app.items.scenes import (
    aliases,
    film_payload,
    read_film,
    read_scene,
    scene_payload,
)
from annotation_app.store.models import Record
from annotation_app.studies.study_file import PracticeItem
from annotation_app.studies.suggestions import suggest
from annotation_app.tasks.clause_words import clauses_of, words_of
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import from_json, parse_brackets

# Translators: seven words of the same kinds in the same order; without, people see the English.
COMMAND = N_("Sail to the buoy by the lighthouse.")


class PracticeExample(msgspec.Struct, frozen=True):
    """Material for a task's practice example."""

    command: str
    """Command typed for the video."""
    words: list[dict[str, Any]]
    """Its words, and where each starts."""
    sdcs: list[Record]
    """Its SDC trees, as :func:`g3.sdc.sdc_notation.to_json` writes them."""
    clauses: list[Record]
    """Node, type and phrase of each clause that words name."""
    watched: Record
    """Page's data of the video."""
    scene: Record
    """Page's data of the video, with outlines and a map."""


@dataclass(frozen=True, slots=True)
class OwnPractice:
    """A practice item of a study's own.

    Parameters
    ----------
    item
        As the study's file has it.
    folder
        Folder with its video's manifest.
    public
        Names under which the page gets the video's files.
    corpus
        Corpus that has the video's world, of a replay.
    """

    item: PracticeItem
    folder: Path
    public: Mapping[str, str]
    corpus: Path | None = None

    @property
    def command(self) -> str:
        """The command; empty if the task needs none."""
        return self.item.command or ""

    def watched(self) -> Record:
        """Return the page's data of the video."""
        film = read_film(self.folder)
        files = {"video": self.public.get("video"), "poster": self.public.get("poster")}
        beside = film.beside.payload(self.public)
        return {**files, "duration_s": film.duration_s, "fps": film.fps, "beside": beside}

    def sdcs(self) -> tuple[SDC, ...]:
        """Return the command's clauses, as the study has them or as the parser finds them."""
        if self.item.clauses:
            return parse_brackets(self.item.clauses, command=self.command)
        found = suggest(self.command)
        return from_json(found[0]) if found is not None else ()

    def scene(self) -> Record:
        """Return the page's data of the video and its things, whose names stay the same."""
        film = read_film(self.folder)
        if not film.has_things:
            return film_payload(film, self.public)
        scene = read_scene(self.folder, self.corpus, self.item.video)
        return scene_payload(scene, aliases(scene, "practice", b""), self.public)


def practice_example() -> PracticeExample:
    """Return the example with its command in the language of the page."""
    return _reworded(_written(), gettext(COMMAND))


@functools.cache
def _written() -> PracticeExample:
    """Return the scene that ``python docs/make_practice.py`` has written."""
    file = resources.files("annotation_app.tasks") / "practice.json"
    return msgspec.json.decode(file.read_bytes(), type=PracticeExample)


def _reworded(example: PracticeExample, command: str) -> PracticeExample:
    """Return the example with another command, word for word; unchanged if word counts differ."""
    words = list(words_of(command))
    if len(words) != len(example.words):
        return example
    new = {old["start"]: word for old, word in zip(example.words, words, strict=True)}

    def worded(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: worded(part) for key, part in value.items()}
        if isinstance(value, list) and value and isinstance(value[0], str):
            return [new[value[1]]["text"], new[value[1]]["start"]]
        return [worded(part) for part in value] if isinstance(value, list) else value

    sdcs = worded(example.sdcs)
    return msgspec.structs.replace(
        example,
        command=command,
        words=words,
        sdcs=sdcs,
        clauses=clauses_of(from_json(sdcs)),
    )
