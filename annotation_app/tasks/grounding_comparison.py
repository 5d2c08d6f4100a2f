"""Answers to a grounding beside each other: what they share, and an answer made of several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.problems import FieldProblem, Refusal
from annotation_app.store.models import Answer, Item, Record
from annotation_app.tasks.clause_words import clauses_of
from annotation_app.tasks.grounding_pictures import draw, lettered
from annotation_app.tasks.task_record import Compared
from g3.sdc.sdc_notation import from_json


def grounding_key(grounding: Record) -> bytes:
    """What two groundings of a clause must share to be the same."""
    return msgspec.json.encode(
        (sorted(grounding["objects"]), grounding["places"], grounding["cant_tell"])
    )


def essence(body: Record) -> Any:
    """What two answers must share to agree: all but how long people took."""
    return body["trims"], {node: grounding_key(g) for node, g in body["groundings"].items()}


def shared_part(one: Record, other: Record) -> float:
    """The part of the clauses that two answers ground alike."""
    first, second = one["groundings"], other["groundings"]
    nodes = first.keys() | second.keys()
    alike = sum(
        node in first
        and node in second
        and grounding_key(first[node]) == grounding_key(second[node])
        for node in nodes
    )
    return alike / len(nodes) if nodes else 1.0


def compare(session: Session, item: Item, bodies: Sequence[Record]) -> Compared:
    """What each clause was grounded to in words, by node, and a picture of all of it."""
    groundings = [grounding for body in bodies for grounding in body["groundings"].values()]
    letters = lettered(groundings)
    sides = tuple(
        {node: shown(grounding, letters) for node, grounding in body["groundings"].items()}
        for body in bodies
    )
    nodes = {node for side in sides for node in side}
    all_clauses = clauses_of(from_json(item.payload["sdcs"]))
    clauses = [clause for clause in all_clauses if str(clause["node"]) in nodes]
    return Compared(sides, {"clauses": clauses, "picture": draw(session, item, groundings)})


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


def mixed_groundings(session: Session, item: Item, form: Mapping[str, str]) -> Record:
    """Groundings that take each clause from an answer.

    Parameters
    ----------
    form
        The answers' ids, by ``node-`` and the node.

    Raises
    ------
    Refusal
        If a clause has no choice, or one that isn't there.
    """
    choices = {
        name.removeprefix("node-"): int(value[:18])
        for name, value in form.items()
        if name.startswith("node-") and value.isdecimal()
    }
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
    whole: Record = {}
    for body in (answers[choice] for choice in dict.fromkeys(choices.values())):
        whole = {**body.get("whole", {}), **whole}
    return {
        "groundings": groundings,
        "trims": trims,
        "whole": {node: how for node, how in whole.items() if node not in trims},
    }
