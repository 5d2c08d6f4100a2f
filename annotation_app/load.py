"""A corpus as a study: what it holds are adopted answers, which annotators may replace."""

from __future__ import annotations

import uuid
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.installation import now
from annotation_app.models import Answer, Event, Handout, Item, Person, Record, Slot, Study, Task
from annotation_app.people import hashed, new_id
from annotation_app.setup import Rendered, add_video, put_media
from annotation_app.study import StudyConfig, TaskConfig, stored
from corpus_tools.corpus.model import Corpus
from g3.annotation import Annotation, Command
from g3.errors import FormatError
from g3.groundings import PhysicalObject, Place
from g3.sdc import breadth_first
from g3.sdc_notation import to_json

PROVIDER = "import"


def import_corpus(
    session: Session,
    corpus: Corpus,
    folder: Path,
    videos: list[Rendered],
    *,
    name: str,
    salt: bytes,
) -> Mapping[str, int]:
    """Add a study that holds a corpus.

    Parameters
    ----------
    folder
        Where the corpus is; the study goes on reading its contexts there.
    videos
        Replays of its contexts.

    Returns
    -------
    mapping
        How many of what there are.

    Raises
    ------
    FormatError
        If there is such a study already, or a context has no video.
    """
    if session.scalar(select(Study.id).where(Study.name == name)) is not None:
        raise FormatError("there is a study of this name", where=name, fix="give --study")
    shown = {item.video: item for item in videos}
    missing = [key for key in corpus.contexts if key not in shown]
    if missing:
        raise FormatError(
            f"the context {missing[0]} has no video",
            where=str(folder),
            fix=f"make it with `ct render-videos --corpus {folder} --out FOLDER`",
        )
    config = StudyConfig(
        name=name,
        title=corpus.name,
        tasks={task: TaskConfig(role="annotator") for task in ("describe", "segment", "ground")},
    )
    study = Study(id=new_id(), name=name, config=stored(config), created_at=now())
    session.add(study)
    session.flush()
    for key in corpus.contexts:
        add_video(session, study.id, shown[key])
        put_media(session, study.id, key, "corpus", folder)
    positives = [a for a in corpus.annotations if a.source == "positive"]
    contexts = _contexts(corpus)
    annotated: dict[str, list[Annotation]] = {}
    for annotation in positives:
        annotated.setdefault(annotation.command.id, []).append(annotation)
    loader = _Loader(session, study, corpus.hash, salt)
    for command in corpus.commands.values():
        video = contexts.get(command.id) or contexts.get(command.scenario)
        if video is not None:
            loader.command(command, video, annotated.get(command.id, []))
    return loader.counts


def _contexts(corpus: Corpus) -> dict[str, str]:
    """In which context commands were given, by their ids and by their scenarios' names."""
    found: dict[str, str] = {}
    for annotation in corpus.annotations:
        found[annotation.command.id] = annotation.context.id
        found.setdefault(annotation.command.scenario, annotation.context.id)
    return found


class _Loader:
    """Adds items with answers, and counts them."""

    def __init__(self, session: Session, study: Study, corpus_hash: str, salt: bytes) -> None:
        self.session = session
        self.study = study
        self.corpus_hash = corpus_hash
        self.salt = salt
        self.people: dict[str, Person] = {}
        self.counts = {"commands": 0, "segmentations": 0, "groundings": 0}

    def command(self, command: Command, video: str, annotations: list[Annotation]) -> None:
        """Add a command, and what it is annotated with."""
        person = self.person(command.subject or command.id)
        body = {
            "text": command.text,
            "watched_s": 0.0,
            "imported": command.id,
            "scenario": command.scenario,
            "video": command.video,
            "subject": command.subject,
        }
        subject = f"study {self.study.name} {command.id}"
        described = self.answer("describe", subject, {"video": video}, person, body)
        self.counts["commands"] += 1
        about = {"text": command.text, "command": described.id, "video": video}
        if not annotations:
            self.item("segment", subject, about)
        for annotation in annotations:
            sdcs = to_json(annotation.sdcs)
            segmented = self.answer(
                "segment",
                f"study {self.study.name} {annotation.id}",
                {**about, "suggestion": sdcs},
                person,
                {"sdcs": sdcs},
            )
            self.answer(
                "ground",
                f"answer {segmented.id}",
                {**about, "sdcs": sdcs},
                person,
                {"groundings": _groundings(annotation), "trims": {}, "imported": annotation.id},
            )
            self.counts["segmentations"] += 1
            self.counts["groundings"] += 1

    def person(self, subject: str) -> Person:
        """Whoever the corpus's subject stands for."""
        if subject not in self.people:
            digest = hashed(self.salt, PROVIDER, f"{self.corpus_hash} {subject}")
            known = self.session.scalars(
                select(Person).where(Person.provider == PROVIDER, Person.external_hash == digest)
            ).first()
            person = known or Person(
                id=new_id(),
                role="worker",
                provider=PROVIDER,
                external_hash=digest,
                profile={},
                created_at=now(),
            )
            self.session.add(person)
            self.session.flush()
            self.people[subject] = person
        return self.people[subject]

    def item(self, task: Task, subject: str, payload: Record) -> Item:
        """Add an item with one slot."""
        item = Item(
            id=new_id(),
            study_id=self.study.id,
            task=task,
            subject=subject,
            payload=payload,
            rank=float(self.counts["commands"]),
            attention=False,
        )
        item.slots = [Slot(answered=False)]
        self.session.add(item)
        self.session.flush()
        return item

    def answer(
        self, task: Task, subject: str, payload: Record, person: Person, body: Record
    ) -> Answer:
        """Add an item that is answered."""
        item, at = self.item(task, subject, payload), now()
        slot = item.slots[0]
        slot.answered, slot.person_id, slot.expires_at = True, person.id, at
        event = Event(
            uuid=str(uuid.uuid4()),
            item_id=item.id,
            person_id=person.id,
            name="submit",
            body=body,
            at=at,
        )
        self.session.add_all([event, Handout(item_id=item.id, person_id=person.id, at=at)])
        self.session.flush()
        answer = Answer(
            item_id=item.id,
            person_id=person.id,
            task=task,
            subject=item.subject,
            event_id=event.id,
            body=body,
            surplus=False,
            adopted=True,
            seconds=0.0,
            at=at,
        )
        self.session.add(answer)
        self.session.flush()
        return answer


def _groundings(annotation: Annotation) -> dict[str, Any]:
    """OBJECT and PLACE groundings as answers have them, for an editor to start from."""
    places = {id(place): i for i, place in enumerate(annotation.context.places)}
    known = {item.id for item in annotation.context.objects}
    found = {}
    pairs = zip(breadth_first(annotation.sdcs), annotation.groundings, strict=True)
    for node, (sdc, groundings) in enumerate(pairs):
        if sdc.type not in ("OBJECT", "PLACE") or not groundings:
            continue
        found[str(node)] = {
            "objects": [
                g.id for g in groundings if isinstance(g, PhysicalObject) and g.id in known
            ],
            "places": [
                {"place": places[id(g)]} if id(g) in places else {"xy": g.prism.xy.tolist()}
                for g in groundings
                if isinstance(g, Place)
            ],
            "cant_tell": False,
            "time_s": 0.0,
        }
    return found
