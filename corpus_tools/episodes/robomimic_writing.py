"""Putting people's language into a copy of robomimic's HDF5 files, as attributes of episodes.

- ``ep_meta``: its ``lang`` (as in RoboCasa) becomes the corrected task, or the first description
  where there is no task. Its other fields stay.
- ``language_descriptions``: an array of the other descriptions.
- ``language_subtasks``: JSON, a list of ``{"start_s", "step", "content"}``; `step` is a frame.
- ``language_moments``: the same of all other styles, with ``style`` and maybe ``camera`` and
  ``reply``.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import msgspec

from corpus_tools.episodes.copies import LanguageCopy, records, wordings
from corpus_tools.episodes.robomimic import (
    FPS,
    Demonstrations,
    child,
    content_of,
    demonstrations,
    json_of,
    tasks_of,
)
from corpus_tools.lerobot.language_rows import SUBTASK, TASK_AUG
from corpus_tools.lerobot.language_writing import EpisodeLanguage
from g3.errors import CorpusError

META, LANGUAGE = "ep_meta", "lang"
DESCRIPTIONS, SUBTASKS, MOMENTS = (
    "language_descriptions", "language_subtasks", "language_moments",
)  # fmt: skip


def write_robomimic(source: Demonstrations, copy: LanguageCopy) -> list[str]:
    """Write copies of a dataset's files with language in them."""
    folder = source.path if source.path.is_dir() else source.path.parent
    seen: set[int] = set()
    with copy.writing(source.path) as (scratch, files):
        copies = []
        for file in source.files:
            name = file.relative_to(folder).as_posix()
            files[name] = new = scratch / name
            new.parent.mkdir(parents=True, exist_ok=True)
            copies.append(Path(shutil.copyfile(file, new)))
        for index, file, data, name in demonstrations(copies, _fail, is_written=True):
            seen.add(index)
            if index in copy.language:
                place = f"{file.relative_to(scratch)}, data/{name}"
                demo = child(data, name, place)
                rate = copy.rates.get(index, FPS)
                with content_of(place):
                    _add_language(data, demo, copy.language[index], rate, place)
        copy.check_written(source.path, seen)
    return []


def _fail(error: CorpusError) -> None:
    raise error


def _add_language(data: Any, demo: Any, added: EpisodeLanguage, rate: float, where: str) -> None:
    tasks = tasks_of(data, demo, where)
    texts = wordings(added)
    task = added.corrected.get(" ".join(tasks[0].split())) if tasks else next(iter(texts), None)
    if task:
        meta = {**json_of(demo, META, where), LANGUAGE: task}
        demo.attrs[META] = msgspec.json.encode(meta).decode()
    others = [text for text in texts if text != task]
    if others:
        demo.attrs[DESCRIPTIONS] = others
    subtasks = [item for item in added.said if item.style == SUBTASK]
    moments = [item for item in added.said if item.style not in (SUBTASK, TASK_AUG)]
    if subtasks:
        steps = [{k: v for k, v in one.items() if k != "style"} for one in records(subtasks, rate)]
        demo.attrs[SUBTASKS] = msgspec.json.encode(steps).decode()
    if moments:
        demo.attrs[MOMENTS] = msgspec.json.encode(records(moments, rate)).decode()
