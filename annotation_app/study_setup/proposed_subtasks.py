"""Steps that models proposed for a study's videos: from tables into the items of people."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.sent_text import clean_text
from annotation_app.items.new_items import REPLACED
from annotation_app.store.models import Item, Study
from annotation_app.study_setup.every_problem import together
from annotation_app.study_setup.own_videos import START, OwnVideo, absolute, short, video_of
from annotation_app.tasks.proposed_steps import PROPOSED
from annotation_app.tasks.subtasks import LONGEST_TEXT, MOST_SUBTASKS, SUBTASKS
from corpus_tools.tables.file_names import find_file, normal_name
from corpus_tools.tables.table_reading import OnNote, Row, lines_named, no_note, read_table
from g3.errors import CorpusError, FormatError

UNNAMED = "dataset"
"""Name of the model of a table that names none."""
MODELS = ("model", "source")
"""Columns that name the model of a row."""

Proposals: TypeAlias = Mapping[str, Mapping[str, list[tuple[float, str]]]]
"""For each video the steps of each model: their beginnings in the video, in seconds, and texts."""


def proposed_subtasks(
    tables: Mapping[str, Path], videos: Sequence[OwnVideo | str], on_note: OnNote = no_note
) -> Proposals:
    """Read the steps that models proposed.

    A row is of the video whose ``episode`` it names, else of its ``video``. It begins at
    ``start_s`` in the file; if its file is none of the study's, at ``timestamp`` in the episode.

    Parameters
    ----------
    tables
        Tables by the names of models; the name may be empty.
    videos
        The study's videos, those of ``ct render-videos`` by their names.
    on_note
        Takes lines about rows that aren't used.

    Raises
    ------
    CorpusError
        If rows are about no video of the study, or are no steps; it lists all.
    """
    found: dict[str, dict[str, list[tuple[float, str]]]] = {}
    errors: list[CorpusError] = []
    lookup = _Videos(videos)
    for name, path in tables.items():
        elsewhere: list[int] = []
        for row in read_table(path, ("video", "command"), on_note):
            try:
                video = lookup.name_of(row)
                if video is None:
                    elsewhere.append(row.line)
                    continue
                model = name or next(filter(None, map(row.text, MODELS)), UNNAMED)
                step = lookup.start_s(row, video), _text(row)
            except CorpusError as error:
                errors.append(error)
                continue
            steps = found.setdefault(video, {}).setdefault(model.strip(), [])
            steps.append(step)
            if len(steps) == MOST_SUBTASKS + 1:
                what = f"the video {video!r} has more than {MOST_SUBTASKS} proposed steps"
                errors.append(FormatError(what, where=row.where(), fix="propose fewer steps"))
        if elsewhere:
            on_note(
                f"{path}: steps of episodes that the study doesn't show, and not used: "
                f"{lines_named(elsewhere)}"
            )
    if errors:
        raise together(errors)
    return {
        video: {model: sorted(steps) for model, steps in models.items()}
        for video, models in found.items()
    }


class _Videos:
    """A study's videos, by what rows name them with."""

    def __init__(self, videos: Sequence[OwnVideo | str]) -> None:
        names = [v if isinstance(v, str) else v.video for v in videos]
        self.names = {normal_name(name): name for name in names}
        self.own = {v.video: v for v in videos if isinstance(v, OwnVideo)}
        self.episodes = {
            str(v.metadata["episode"]): v.video
            for v in self.own.values()
            if "episode" in v.metadata and "style" not in v.metadata
        }
        self.files: dict[Path, list[str]] = {}
        for item in self.own.values():
            if item.part is None:
                self.files.setdefault(item.file, []).append(item.video)

    def name_of(self, row: Row) -> str | None:
        """Return the video of a row; None if its episode isn't shown."""
        episode = row.text("episode").strip()
        if episode and self.episodes:
            return self.episodes.get(episode)
        return video_of(row, self.names, self.files)

    def start_s(self, row: Row, video: str) -> float:
        """Return where in the video a row's step begins, in seconds."""
        item = self.own.get(video)
        column, before_s = START, 0.0
        if item is not None:
            file = absolute(find_file(row.table.parent, row.text("video")))
            is_other = normal_name(row.text("video")) not in self.names and file != item.file
            if is_other and row.text("timestamp").strip():
                column = "timestamp"
            elif item.part is not None:
                before_s = item.part[0]
        try:
            start_s = float(row.text(column)) - before_s
        except ValueError:
            start_s = math.nan
        # Tables have six digits.
        if not -1e-5 <= start_s < math.inf:
            what = f"{short(row.text(column))!r} is no time in the video {video!r}"
            if before_s:
                what += f", which begins at {before_s:g} s of its file"
            fix = "give the time at which the step begins, in seconds"
            raise FormatError(what, where=row.where(column), fix=fix)
        return max(round(start_s, 6), 0.0)


def _text(row: Row) -> str:
    text = clean_text(row.text("command"))
    if any(character.isalnum() for character in text) and len(text) <= LONGEST_TEXT:
        return text
    what = f"a step needs a text of at most {LONGEST_TEXT} characters"
    raise FormatError(what, where=row.where("command"), fix="correct the text, or remove the row")


def put_proposals(session: Session, study: Study, proposals: Proposals) -> None:
    """Give each item of the task the proposals for its video, in place of earlier ones.

    What people have been offered stays as it was.
    """
    items = session.scalars(
        select(Item).where(
            Item.study_id == study.id,
            Item.task == SUBTASKS.name,
            ~Item.subject.startswith(REPLACED),
        )
    )
    by_name = {normal_name(video): models for video, models in proposals.items()}
    for item in items:
        models = by_name.get(normal_name(item.payload["video"]), {})
        payload = {name: value for name, value in item.payload.items() if name != PROPOSED}
        if models:
            payload[PROPOSED] = {m: [list(step) for step in steps] for m, steps in models.items()}
        if payload != item.payload:
            item.payload = payload
