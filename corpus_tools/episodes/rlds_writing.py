"""Putting people's language into a copy of an RLDS dataset.

An RLDS dataset has its language at the steps. The first description becomes the instruction of an
episode that has none; others get features of their own, ``language_instruction_2`` and so on, as
DROID has them; subtasks become ``language_subtask``, and corrected tasks take the place of wrong
ones. Everything else of a record stays.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from corpus_tools.episodes.copies import LanguageCopy, style_counts, wordings
from corpus_tools.episodes.films import RESTORE
from corpus_tools.episodes.rlds import FEATURES, FPS, INFO, STEPS, Steps, text_of
from corpus_tools.episodes.tf_records import example_of, framed, records, values_of
from corpus_tools.lerobot.dataset_files import file_inside
from corpus_tools.lerobot.language_rows import SUBTASK, TASK_AUG, placed
from corpus_tools.lerobot.language_writing import EpisodeLanguage
from g3.errors import FormatError
from g3.storage.regular_file import read_bytes

INSTRUCTION, SUBTASKS = "language_instruction", "language_subtask"
TEXT = {
    "pythonClassName": "tensorflow_datasets.core.features.text_feature.Text",
    "text": {},
}
"""The entry of a text in ``features.json``."""


@dataclass(frozen=True, slots=True)
class _Columns:
    """Names of the features with language."""

    there: tuple[str, ...]
    """The dataset's own, with tasks."""
    instruction: str
    more: tuple[str, ...]
    """Names for the descriptions after the instruction."""
    subtasks: str


def write_rlds(steps: Steps, copy: LanguageCopy) -> list[str]:
    """Write a copy of a dataset with language in it.

    Returns
    -------
    list of str
        The texts that aren't written or are at another step than the nearest, and the shards that
        aren't there.
    """
    source, columns = steps.path, _columns(steps, copy.language)
    notes = [*_not_written(copy.language)]
    seen: set[int] = set()
    with copy.writing(source, INFO) as (scratch, files):
        shards = {shard.file.name: shard for shard in steps.shards}
        sizes: dict[str, int] = {}
        for name, shard in shards.items():
            if not shard.file.exists():
                notes.append(f"{name} isn't there, so it isn't in the copy")
                continue
            files[name] = new = scratch / name
            with new.open("wb") as stream:
                for number, content in enumerate(records(shard.file)):
                    where = f"{shard.file}, record {number}"
                    if number >= len(shard.episodes):
                        what = f"the shard has more records than {INFO} has of it"
                        raise FormatError(what, where=where, fix=RESTORE)
                    index = shard.episodes[number]
                    seen.add(index)
                    added = copy.language.get(index, EpisodeLanguage(()))
                    example = example_of(content, where)
                    rate = copy.rates.get(index, FPS)
                    found = _add_language(example, added, columns, rate, where)
                    notes += [f"episode {index}: {note}" for note in found]
                    stream.write(framed(example.SerializeToString(deterministic=True)))
            sizes[name] = new.stat().st_size
        copy.check_written(source, seen)
        for path in sorted(source.iterdir()):
            if path.name not in shards and not path.name.startswith(".") and path.is_file():
                file = file_inside(source, path.name, where=str(path))
                files[path.name] = Path(shutil.copyfile(file, scratch / path.name))
        files[INFO] = _info(source / INFO, sizes)
        files[FEATURES] = _with_features(source / FEATURES, columns)
    return notes


def _columns(steps: Steps, language: Mapping[int, EpisodeLanguage]) -> _Columns:
    names = {feature.name for feature in steps.features}
    instruction = steps.texts[0] if steps.texts else INSTRUCTION
    most = max((len(wordings(added)) for added in language.values()), default=0)
    numbered = (f"{instruction}_{number}" for number in range(2, 2 + len(names) + most))
    free = [name for name in numbered if name not in names]
    return _Columns(steps.texts, instruction, tuple(free[:most]), SUBTASKS)


def _not_written(language: Mapping[int, EpisodeLanguage]) -> Iterator[str]:
    styles = style_counts(language)
    for style in sorted(styles.keys() - {TASK_AUG, SUBTASK}):
        yield f"{styles[style]} texts of the style {style} are in no record: RLDS has no such style"


def _add_language(
    example: Any, added: EpisodeLanguage, columns: _Columns, rate: float, where: str
) -> Iterator[str]:
    """Add the features to an example; yield what isn't written where it should be."""
    count = _count(example, where)
    for name in columns.there if added.corrected else ():
        texts = [text_of(value, where) for value in values_of(example, f"{STEPS}{name}")]
        new = [added.corrected.get(" ".join(text.split()), text) for text in texts]
        if new != texts:
            _put(example, name, new)
    before = values_of(example, f"{STEPS}{columns.instruction}")
    has = any(text_of(value, where) for value in before)
    texts = wordings(added)
    if not has:
        text, *texts = texts or [""]
        _put(example, columns.instruction, [text] * count)
    for number, name in enumerate(columns.more):
        text = texts[number] if number < len(texts) else ""
        _put(example, name, [text] * count)
    subtasks = [item for item in added.said if item.style == SUBTASK]
    if not subtasks and len(values_of(example, f"{STEPS}{columns.subtasks}")) == count:
        return  # those of the dataset stay
    every = [""] * count
    at = placed(subtasks, np.arange(count) / rate, 1 / rate) if subtasks else []
    for item in sorted(at, key=lambda one: -1 if one.frame is None else one.frame):
        if item.note:
            yield f"{item.language.text!r:.60}: {item.note}"
        if item.frame is not None:
            every[item.frame :] = [item.language.text] * (count - item.frame)
    _put(example, columns.subtasks, every)


def _count(example: Any, where: str) -> int:
    """Return the number of steps: the length of most features, those of a number or text each."""
    names = [*example.context.feature, *example.feature_lists.feature_list]
    for name in (f"{STEPS}is_first", *sorted(names)):
        values = values_of(example, name)
        if name.startswith(STEPS) and values and (name == f"{STEPS}is_first" or _is_bytes(values)):
            return len(values)
    what = "the episode has no steps with is_first, a text or an image"
    raise FormatError(what, where=where, fix=RESTORE)


def _is_bytes(values: Sequence[Any]) -> bool:
    return isinstance(values[0], bytes)


def _put(example: Any, name: str, texts: Sequence[str]) -> None:
    contents = [text.encode() for text in texts]
    lists = example.feature_lists.feature_list
    if len(lists):  # a sequence example
        del lists[f"{STEPS}{name}"].feature[:]
        for content in contents:
            lists[f"{STEPS}{name}"].feature.add().bytes_list.value.append(content)
        return
    feature = example.context.feature[f"{STEPS}{name}"]
    feature.Clear()
    feature.bytes_list.value.extend(contents)


def _info(file: Path, sizes: Mapping[str, int]) -> bytes:
    """Return ``dataset_info.json`` with the new numbers of bytes."""
    info = msgspec.json.decode(read_bytes(file))
    for split in info["splits"]:
        part = f"-{split['name']}."
        split["numBytes"] = str(sum(size for name, size in sizes.items() if part in name))
    return json.dumps(info, indent=2, ensure_ascii=False).encode()


def _with_features(file: Path, columns: _Columns) -> bytes:
    features = msgspec.json.decode(read_bytes(file))
    of_step = features["featuresDict"]["features"]["steps"]["sequence"]["feature"]
    for name in (columns.instruction, *columns.more, columns.subtasks):
        *groups, last = name.split("/")
        place = of_step
        for group in groups:
            place = place["featuresDict"]["features"][group]
        place["featuresDict"]["features"].setdefault(last, TEXT)
    return json.dumps(features, indent=4, ensure_ascii=False).encode()
