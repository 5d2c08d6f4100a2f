"""What people disagree about, and the decisions of adjudicators."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import msgspec
from sqlalchemy import exists, func, select
from sqlalchemy.orm import Session, aliased

from annotation_app.core.problems import FieldProblem, Refusal
from annotation_app.dashboard.pictures import Picture, draw, lettered
from annotation_app.store.models import Answer, Event, Item, Person, Record, Slot, Study, Task
from annotation_app.tasks import pipeline
from annotation_app.tasks.agreement import tree_f
from annotation_app.tasks.answers import segmentation_problems
from annotation_app.tasks.payloads import clauses_of
from annotation_app.tasks.submissions import add_event
from g3.errors import SDCError
from g3.sdc.sdc_drawing import to_svg
from g3.sdc.sdc_notation import format_brackets, from_json, parse_brackets, to_json

ADJUDICATED: tuple[Task, ...] = ("segment", "ground")


@dataclass(frozen=True, slots=True)
class Dispute:
    """An item with several answers, none of which was adopted."""

    item: str
    task: Task
    command: str
    answers: int


@dataclass(frozen=True, slots=True)
class Side:
    """An answer, to be compared with another one.

    Parameters
    ----------
    clauses
        For groundings: what each clause was grounded to, by node.
    notation
        For segmentations: the clauses as text.
    drawing
        For segmentations: the clauses as SVG.
    """

    answer: int
    subject: str
    seconds: float | None
    notation: str
    drawing: str
    clauses: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Comparison:
    """The answers to an item, side by side.

    Parameters
    ----------
    clauses
        For groundings: node, type and phrase of each clause.
    agreement
        Tree F of the first two segmentations, or the part of the clauses that are grounded
        alike.
    picture
        For groundings: what the answers speak of.
    """

    item: str
    task: Task
    command: str
    sides: tuple[Side, ...]
    clauses: tuple[Record, ...]
    agreement: float
    picture: Picture | None


def disputes(session: Session, study_id: str) -> list[Dispute]:
    """What is to be decided, oldest first: all answers that are wanted are there."""
    other = aliased(Answer)
    rows = session.execute(
        select(Item, func.count(Answer.id))
        .join(Answer, Answer.item_id == Item.id)
        .where(
            Item.study_id == study_id,
            Item.task.in_(ADJUDICATED),
            ~exists().where(other.item_id == Item.id, other.adopted),
            ~exists().where(Slot.item_id == Item.id, Slot.answered.is_(False)),
        )
        .group_by(Item.id)
        .having(func.count(Answer.id) > 1)
        .order_by(func.min(Answer.id))
    )
    return [Dispute(item.id, item.task, item.payload["text"], count) for item, count in rows]


def compare(session: Session, item: Item) -> Comparison:
    """An item's answers side by side."""
    rows = session.execute(
        select(Answer, Person)
        .join(Person, Person.id == Answer.person_id)
        .where(Answer.item_id == item.id)
        .order_by(Answer.id)
    ).all()
    groundings = [g for answer, _ in rows for g in answer.body.get("groundings", {}).values()]
    letters = lettered(groundings)
    sides = tuple(_side(item, answer, person, letters) for answer, person in rows)
    clauses: list[Record] = []
    if item.task == "ground":
        nodes = {node for side in sides for node in side.clauses}
        all_clauses = clauses_of(from_json(item.payload["sdcs"]))
        clauses = [clause for clause in all_clauses if str(clause["node"]) in nodes]
    return Comparison(
        item.id,
        item.task,
        item.payload["text"],
        sides,
        tuple(clauses),
        _agreement(item, [answer.body for answer, _ in rows]),
        draw(session, item, groundings) if item.task == "ground" else None,
    )


def _side(item: Item, answer: Answer, person: Person, letters: Mapping[str, str]) -> Side:
    from annotation_app.export.corpus_export import subject_of  # noqa: PLC0415 - export reads whole corpora

    sdcs = from_json(answer.body["sdcs"]) if item.task == "segment" else ()
    return Side(
        answer.id,
        subject_of(person),
        answer.seconds,
        format_brackets(sdcs),
        to_svg(sdcs) if sdcs else "",
        {node: shown(g, letters) for node, g in answer.body.get("groundings", {}).items()},
    )


def shown(grounding: Record, letters: Mapping[str, str]) -> str:
    """A clause's grounding in words, with the letters that objects have in the picture."""
    if grounding["cant_tell"]:
        return "can't tell"
    things = [f"{letters[name]} ({name})" for name in grounding["objects"]]
    for place in grounding["places"]:
        if place.get("place") is not None:
            things.append(f"place {place['place']} of the map")
        else:
            xs, ys = zip(*place["xy"], strict=True)
            things.append(f"area around ({sum(xs) / len(xs):.1f}, {sum(ys) / len(ys):.1f}) m")
    return ", ".join(things) or "nothing"


def choose(
    session: Session,
    study: Study,
    item: Item,
    person: Person,
    answer_id: int,
    *,
    uuid: str,
    now: float,
) -> None:
    """Adopt one of an item's answers.

    Raises
    ------
    Refusal
        If it isn't one of them.
    """
    answer = session.get(Answer, answer_id)
    if answer is None or answer.item_id != item.id:
        raise Refusal(422, "Choose one of the answers.")
    if _is_known(session, person, uuid):
        return
    add_event(
        session, item, person.id, name="adjudicate", uuid=uuid, body={"answer": answer_id}, now=now
    )
    pipeline.adopt(session, study, item, answer)


def edit(
    session: Session,
    study: Study,
    item: Item,
    person: Person,
    body: Record,
    *,
    uuid: str,
    now: float,
) -> None:
    """Adopt an answer of the adjudicator's own, made of the others."""
    if _is_known(session, person, uuid):
        return
    sent = {"body": body}
    pipeline.adjudicate(session, study, item, person, uuid=uuid, sent=sent, body=body, now=now)


def edited_trees(item: Item, notation: str) -> Record:
    """A segmentation from what somebody typed.

    Raises
    ------
    Refusal
        With what is wrong with it.
    """
    text = item.payload["text"]
    try:
        sdcs = parse_brackets(notation, command=text)
    except SDCError as error:
        raise Refusal(
            422, "The clauses can't be read.", [FieldProblem("notation", str(error))]
        ) from error
    problems = segmentation_problems(sdcs, text)
    if problems:
        raise Refusal(422, "The clauses must be changed.", problems)
    return {"sdcs": to_json(sdcs)}


def mixed_groundings(session: Session, item: Item, choices: Mapping[str, int]) -> Record:
    """Groundings that take each clause from an answer.

    Parameters
    ----------
    choices
        The answers' ids by node.

    Raises
    ------
    Refusal
        If a clause has no choice, or one that isn't there.
    """
    answers = {
        answer.id: answer.body
        for answer in session.scalars(select(Answer).where(Answer.item_id == item.id))
    }
    nodes = sorted({n for body in answers.values() for n in body["groundings"]}, key=int)
    groundings: Record = {}
    trims: Record = {}
    for node in nodes:
        body = answers.get(choices.get(node, -1), {"groundings": {}})
        if node not in body["groundings"]:
            raise Refusal(
                422, "Choose for each clause.", [FieldProblem(node, "Choose one of the answers.")]
            )
        groundings[node] = body["groundings"][node]
    for body in (answers[choice] for choice in dict.fromkeys(choices.values())):
        trims = {**body.get("trims", {}), **trims}
    return {"groundings": groundings, "trims": trims}


def _agreement(item: Item, bodies: list[Record]) -> float:
    if len(bodies) < 2:
        return 1.0
    first, second = bodies[:2]
    if item.task == "segment":
        return tree_f(from_json(first["sdcs"]), from_json(second["sdcs"]))
    one, other = first["groundings"], second["groundings"]
    nodes = one.keys() | other.keys()
    alike = sum(
        node in one and node in other and _key(one[node]) == _key(other[node]) for node in nodes
    )
    return alike / len(nodes) if nodes else 1.0


def _key(grounding: Record) -> bytes:
    return msgspec.json.encode(
        (sorted(grounding["objects"]), grounding["places"], grounding["cant_tell"])
    )


def _is_known(session: Session, person: Person, uuid: str) -> bool:
    known = select(Event.id).where(Event.person_id == person.id, Event.uuid == uuid)
    return session.scalar(known) is not None
