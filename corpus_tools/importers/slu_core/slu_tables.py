"""Assignments (commands with their authors) and evaluations (people's judgments)."""

from __future__ import annotations

import hashlib
import hmac
from typing import Any, get_args

from corpus_tools.importers.report import Journal
from corpus_tools.importers.slu_core.slu_files import (
    ASSIGNMENTS,
    EVALUATIONS,
    SCENARIOS,
    Layout,
    read_records,
)
from g3.annotation import Command, Judgment, Rating
from g3.errors import FormatError

HASH_LENGTH = 12


def hash_subject(worker: object, salt: str) -> str:
    """Hash a worker's id: the same for the same worker and salt, and irreversible."""
    if not worker:
        return ""
    digest = hmac.new(salt.encode(), str(worker).encode(), hashlib.sha256)
    return digest.hexdigest()[:HASH_LENGTH]


def read_assignments(
    layout: Layout, scenario: str, salt: str, journal: Journal
) -> dict[str, Command]:
    """Read the commands typed for a scenario, by assignment.

    A command's id is the scenario and its number in the file, such as
    ``move_tire_pallet-03``.
    """
    commands: dict[str, Command] = {}
    file, records = read_records(layout, f"{SCENARIOS}/{scenario}/{ASSIGNMENTS}", journal)
    for number, record in enumerate(records, start=1):
        try:
            assignment, text, video = _fields(record, "assignmentId", "command", "youtubeId")
            if assignment in commands:
                raise FormatError(
                    f"the assignment {assignment} occurs twice",
                    where="assignmentId",
                    fix="remove one of them",
                )
        except FormatError as error:
            journal.skip(file, f"record {number}", error)
            continue
        name = f"{scenario}-{number:02}"
        if not text.strip():
            journal.note("nothing was typed", name)
        commands[assignment] = Command(
            id=name,
            text=text,
            scenario=scenario,
            video=video,
            subject=hash_subject(record.get("workerId"), salt),
        )
    return commands


def read_judgments(layout: Layout, scenario: str, salt: str, journal: Journal) -> list[Judgment]:
    """Read the judgments of a scenario's commands; a study is named after its file."""
    judgments: list[Judgment] = []
    for name in EVALUATIONS:
        study = name.removesuffix(".yaml")
        file, records = read_records(layout, f"{SCENARIOS}/{scenario}/{name}", journal)
        for number, record in enumerate(records, start=1):
            try:
                judgment = _judgment(record, f"{scenario}/{study}-{number:03}", study, salt)
            except FormatError as error:
                journal.skip(file, f"record {number}", error)
                continue
            judgments.append(judgment)
    return judgments


def _judgment(record: Any, name: str, study: str, salt: str) -> Judgment:
    command, command_video, shown_video = _fields(
        record, "command", "commandYoutubeId", "displayedYoutubeId"
    )
    return Judgment(
        id=name,
        command=command,
        command_video=command_video,
        shown_video=shown_video,
        rating=_rating(record.get("similarityScore")),
        subject=hash_subject(record.get("workerId"), salt),
        study=study,
    )


def _rating(value: object) -> Rating:
    ratings: tuple[Rating, ...] = get_args(Rating)
    for rating in ratings:
        if value == rating:
            return rating
    raise FormatError(
        f"{value!r} is not a rating",
        where="similarityScore",
        fix=f"use one of {', '.join(ratings)}",
    )


def _fields(record: Any, *names: str) -> list[str]:
    if not isinstance(record, dict):
        raise FormatError("this is not a mapping", fix=f"it needs {', '.join(names)}")
    for name in names:
        if not isinstance(record.get(name), str | int):
            raise FormatError("the value is missing", where=name, fix="add it")
    return [str(record[name]) for name in names]
