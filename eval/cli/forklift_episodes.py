"""A small LeRobot dataset of the forklift, with language such as a model writes, and its mistakes.

The mistakes are planted: a file lists them, so that reports on the model can be checked.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.language_rows import PLAN, SUBTASK, TASK_AUG, Language
from corpus_tools.lerobot.language_writing import EpisodeLanguage, write_language
from g3.annotation import Command
from g3.storage.atomic_file import write_bytes

CORPUS = "warehouse"

Cut = tuple[tuple[float, str], ...]
"""Subtasks: the time in seconds at which each begins, and its text."""


@dataclass(frozen=True, slots=True)
class Episode:
    """An episode: its true subtasks, and what is wrong in the dataset's language."""

    steps: Cut
    """The true subtasks, read off the bundled log: where the forklift or its forks stop or turn."""
    kind: str
    """Correction that it needs: a boundary moved, a text changed, a step added or removed."""
    wrong: tuple[float, str] | None
    """The subtask that the dataset has; None where one is missing."""
    right: tuple[float, str] | None
    """The true subtask that it stands for; None where there is none."""
    wrong_task: str = ""
    """The dataset's task, if that is wrong."""

    @property
    def written(self) -> Cut:
        """The dataset's subtasks."""
        kept = [step for step in self.steps if step != self.right]
        return tuple(sorted([*kept, *([self.wrong] if self.wrong else [])]))


EPISODES: Mapping[str, Episode] = {
    "aisles_put_tires_in_storage_e": Episode(
        steps=(
            (0.0, "drive down the aisle to storage E"),
            (13.8, "move the tires into storage E"),
            (16.8, "put the tires down"),
            (19.2, "back away from the tires"),
        ),
        kind="boundary moved",
        wrong=(14.8, "put the tires down"),
        right=(16.8, "put the tires down"),
    ),
    "court_pick_up_boxes_from_trailer": Episode(
        steps=(
            (0.0, "drive to the trailer"),
            (6.0, "raise the forks"),
            (9.4, "move the forks under the boxes"),
            (12.6, "lift the boxes"),
            (15.4, "back away from the trailer"),
        ),
        kind="text changed",
        wrong=(12.6, "lift the tires"),
        right=(12.6, "lift the boxes"),
    ),
    "dock_pick_up_tires": Episode(
        steps=(
            (0.0, "drive to the tires on the right"),
            (6.6, "move the forks under the tires"),
            (9.6, "lift the tires"),
            (12.6, "back away with the tires"),
        ),
        kind="added",
        wrong=None,
        right=(9.6, "lift the tires"),
        wrong_task="Pick up the boxes on the left.",
    ),
    "yard_put_boxes_down_on_trailer": Episode(
        steps=(
            (0.0, "drive to the trailer"),
            (6.6, "raise the boxes"),
            (10.2, "move the boxes over the trailer"),
            (13.2, "put the boxes down beside the tires"),
            (15.6, "back away from the trailer"),
        ),
        kind="removed",
        wrong=(3.4, "wait for the person to pass"),
        right=None,
    ),
}
"""The episodes by the scenarios that they show, in the dataset's order."""


def planted() -> list[dict[str, Any]]:
    """Return the mistakes in the dataset's language, each with the truth."""
    mistakes = []
    for index, (scenario, episode) in enumerate(EPISODES.items()):
        cut = {"dataset": _subtask(episode.wrong), "truth": _subtask(episode.right)}
        mistakes.append({"episode_index": index, "style": "subtask", "kind": episode.kind, **cut})
        if episode.wrong_task:
            task = {"dataset": episode.wrong_task, "truth": _command(scenario).text}
            mistakes.append(
                {"episode_index": index, "style": "task", "kind": "text changed", **task}
            )
    return mistakes


def _subtask(step: tuple[float, str] | None) -> dict[str, Any] | None:
    return None if step is None else {"start_s": step[0], "content": step[1]}


def _command(scenario: str) -> Command:
    """Return the first bundled command of a scenario."""
    return next(c for c in open_corpus(CORPUS).commands.values() if c.scenario == scenario)


def write_corpus(target: Path) -> None:
    """Write the episodes' worlds, each with the task that the dataset will have."""
    whole = open_corpus(CORPUS)
    Corpus.build(
        "forklift-episodes",
        contexts=[whole.contexts[scenario] for scenario in EPISODES],
        commands=[
            replace(command, text=episode.wrong_task or command.text)
            for scenario, episode in EPISODES.items()
            for command in [_command(scenario)]
        ],
        annotations=[],
        source=whole.source,
        licence=whole.licence,
    ).save(target)


def write_dataset(recorded: Path, target: Path, mistakes: Path) -> None:
    """Write a copy of a dataset with the subtasks, and the list of what is wrong in them."""
    replaced = frozenset({SUBTASK, PLAN, TASK_AUG})
    language = {
        index: EpisodeLanguage(
            tuple(Language(SUBTASK, start_s, text) for start_s, text in episode.written), replaced
        )
        for index, episode in enumerate(EPISODES.values())
    }
    write_bytes(mistakes, json.dumps({"mistakes": planted()}, indent=2).encode() + b"\n")
    write_language(open_dataset(recorded), target, language, attachments={})
