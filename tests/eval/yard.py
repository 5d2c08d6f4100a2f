"""A yard with a refrigerator, a washing machine and a trailer, as a corpus with outcomes."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.importers.slu_core.slu_corpus import import_parts
from tests.corpus_tools.importers.random_tasks import (
    DRIVE,
    PICK_UP,
    TO_CHECKPOINT,
    TO_TRAILER,
    log,
    objects,
    pallet,
    put_world,
    thing,
)

LOADS = (pallet("11", "19", "1 2 0"), pallet("12", "25", "1 -4 0"))
"""A refrigerator ahead of the robot, to the left, and a washing machine to the right."""
TRAILER, OTHER_TRAILER = thing("13", "5", "0 10 0"), thing("15", "5", "0 -14 0")
OPERATOR = thing("14", "8", "5 5 0.3")
TASKS = {
    "held": (PICK_UP.format("11"), ("Pick up the refrigerator.", "Lift the thing on the left.")),
    "trailer": (TO_TRAILER.format("12"), ("Put the washing machine on the trailer.",)),
    "ground": (TO_CHECKPOINT.format("12", "3"), ("Pick up the washer and put it down.",)),
    "drive": (DRIVE.format("21"), ("Turn around and go.",)),
}
FEW = ("court_put_crate_on_trailer-01", "hall_pick_up_boxes-01")


def commands_of(texts: tuple[str, ...]) -> str:
    lines = (
        f"- {{assignmentId: A{n}, command: {text!r}, workerId: W{n}, youtubeId: vid}}"
        for n, text in enumerate(texts)
    )
    return "\n".join(lines) + "\n"


def yard(folder: Path, *, two_trailers: bool = False) -> Corpus:
    """A world in which the refrigerator was picked up."""
    things = [*LOADS, TRAILER, OPERATOR, *([OTHER_TRAILER] if two_trailers else [])]
    group = folder / "forklift.automatic.v1"
    put_world(group, "one", xml=objects(*things))
    return import_parts(folder, salt="s", part="automatic")[0]


def yards(folder: Path) -> Corpus:
    """A world for each of `TASKS`, and one with a single load."""
    group = folder / "forklift.automatic.v1"
    for name, (task, texts) in TASKS.items():
        world = objects(*LOADS, TRAILER, OPERATOR)
        put_world(group, name, xml=world, status=log(task), commands=commands_of(texts))
    single = objects(LOADS[0], TRAILER)
    put_world(group, "single", xml=single, commands=commands_of(("Pick up the pallet.",)))
    return import_parts(folder, salt="s", part="automatic")[0]


def few_annotated(wanted: Collection[str] = FEW, name: str = "few") -> Corpus:
    """Annotated commands of the bundled corpus, two of them if none are named."""
    whole = open_corpus("warehouse")
    annotations = [a for a in whole.annotations if a.command.id in wanted]
    return Corpus.build(
        name,
        contexts=list({a.context.id: a.context for a in annotations}.values()),
        commands=list({a.command.id: a.command for a in annotations}.values()),
        annotations=annotations,
    )
