"""Random negatives where nobody knows what is where: a command with the video of another one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import has_things
from annotation_app.items.new_items import NewItem, about_answer, draws, videos_of
from annotation_app.store.models import Answer, Item, Record, Study, TaskName
from annotation_app.studies.study_file import StudyConfig
from annotation_app.tasks.clause_words import clauses_of
from annotation_app.tasks.corpus_parts import answers_of
from g3.sdc.sdc_notation import from_json

HAPPENS = ("EVENT", "PATH")
COLUMNS = (
    "item", "command", "video", "shown_video", "clause", "type", "phrase", "objects", "places",
    "matches", "does_not_match", "cant_tell", "label",
)  # fmt: skip


def with_another_video(
    session: Session, config: StudyConfig, item: Item, answer: Answer, task: TaskName
) -> Iterator[NewItem]:
    """An item that asks of a command's EVENTs and PATHs whether another video shows them.

    It is drawn from the study's videos, but not from those for which somebody has given the very
    same command. There is none where it is known what is where: then things are drawn, too.
    """
    own, text = item.payload["video"], item.payload["text"]
    if has_things(session, item.study_id, own):
        return
    same = select(Item.video).where(
        Item.study_id == item.study_id, Item.task == item.task, Item.command == text
    )
    known = {own, *session.scalars(same)}
    others = [video for video in videos_of(session, item.study_id) if video not in known]
    sdcs = answer.body["sdcs"]
    nodes = [c["node"] for c in clauses_of(from_json(sdcs)) if c["type"] in HAPPENS]
    if others and nodes:
        subject = about_answer(answer)
        video = others[int(draws(config, subject).integers(len(others)))]
        shown = {str(node): {"video": video, "objects": [], "places": []} for node in nodes}
        about = {"text": text, "command": item.payload["command"], "video": own, "sdcs": sdcs}
        yield NewItem(task, subject, {**about, "shown": shown})


def verdict_rows(session: Session, study: Study) -> Iterator[tuple[object, ...]]:
    """For each clause that was checked: what was shown with it, and how often it matched."""
    found: dict[str, tuple[Item, list[Record]]] = {}
    for answer, item in answers_of(session, study, "check", adopted=True):
        found.setdefault(item.id, (item, []))[1].append(answer.body["verdicts"])
    for item, verdicts in found.values():
        for clause in clauses_of(from_json(item.payload["sdcs"])):
            shown = item.payload["shown"].get(str(clause["node"]))
            given = Counter(v[str(clause["node"])] for v in verdicts if str(clause["node"]) in v)
            if shown is not None:
                yes, no = given[True], given[False]
                label = "" if yes == no else "true" if yes > no else "false"
                places = " ".join(map(str, shown["places"]))
                about = (item.id, item.payload["text"], item.payload["video"], shown["video"])
                of = (clause["node"], clause["type"], clause["phrase"])
                counts = (yes, no, given["cant_tell"], label)
                yield (*about, *of, " ".join(shown["objects"]), places, *counts)
