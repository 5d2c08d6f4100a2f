"""A corpus small enough to train on in a test: three scenarios, each with a truck and a pallet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from g3.annotation import Annotation, Command, Judgment, Source
from g3.groundings import Context, Grounding, Path, PhysicalObject, Place, Prism, Trajectory
from g3.sdc.clauses import all_words
from g3.sdc.sdc_notation import parse_brackets
from tests.worlds import line, log, prism, still

SCENARIOS = ("to_pallet", "to_truck", "put_on_truck")

GO = "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the {0})))"
PUT = "EVENT(r = Put, l = OBJ(f = the {0}), l2 = PLACE(r = on, l = OBJ(f = the {1})))"


def box(x: float, y: float, height: float = 1.0) -> Prism:
    return prism(x, y, (2, 1), (0.0, height))


def drive(start: tuple[float, float], end: tuple[float, float]) -> Trajectory:
    heading = np.arctan2(end[1] - start[1], end[0] - start[0])
    return log(line(start, end, 9), float(heading))


def tiny_corpus(scenarios: Sequence[str] = SCENARIOS, *, shift: float = 0.0) -> Corpus:
    """Two or three commands a scenario, each with right and with random groundings.

    Parameters
    ----------
    scenarios
        Some of `SCENARIOS`.
    shift
        Moves everything, so that the worlds are others, in metres.
    """
    contexts, commands, annotations = [], [], []
    for name in scenarios:
        number = SCENARIOS.index(name)
        pallet_at, truck_at = (8.0 + number + shift, 4.0 - number), (7.0, -6.0 - number + shift)
        pallet = PhysicalObject("pallet", ("tire", "pallet"), box(*pallet_at), still(*pallet_at))
        truck = PhysicalObject("truck", ("truck",), box(*truck_at, 1.5), still(*truck_at))
        to_pallet, to_truck = drive((shift, 0.0), pallet_at), drive((shift, 0.0), truck_at)
        path = to_pallet if name == "to_pallet" else to_truck
        other = to_truck if name == "to_pallet" else to_pallet
        forklift = PhysicalObject("forklift", ("forklift",), box(shift, 0.0), path)
        on_truck, beside = Place(box(*truck_at, 2.5)), Place(box(shift, 9.0))
        context = Context(f"{name}/world", (forklift, pallet, truck), (beside,), "forklift")
        contexts.append(context)

        if name == "put_on_truck":
            notations = [PUT.format("tire pallet", "truck"), PUT.format("pallet", "truck")]
            right = [(Path(path),), (), (pallet,), (on_truck,), (truck,)]
            wrong = [(Path(other),), (), (truck,), (beside,), (pallet,)]
        else:
            target, word = (pallet, "pallet") if name == "to_pallet" else (truck, "truck")
            notations = [GO.format(word), GO.format(word), f"OBJ(f = the {word})"]
            right = [(Path(path),), (), (Path(path),), (target,)]
            wrong = [(Path(other),), (), (Path(other),), (truck if target is pallet else pallet,)]
        for index, notation in enumerate(notations):
            leaf = notation.startswith("OBJ")
            command = Command(f"{name}-{index}", _text(notation), name, f"{name} video")
            commands.append(command)
            for source, groundings in (("positive", right), ("random", wrong)):
                chosen = groundings[-1:] if leaf else groundings
                annotations.append(_annotation(command, context, notation, chosen, source))
    return Corpus.build(
        "tiny", contexts=contexts, commands=commands, annotations=annotations, source="made up"
    )


def _text(notation: str) -> str:
    (sdc,) = parse_brackets(notation)
    return " ".join(span.text for span in all_words(sdc))


def _annotation(
    command: Command,
    context: Context,
    notation: str,
    groundings: Sequence[tuple[Grounding, ...]],
    source: Source,
) -> Annotation:
    return Annotation(
        f"{command.id}/{source}",
        command,
        context,
        parse_brackets(notation, command=command.text),
        tuple(groundings),
        tuple((source == "positive") if g else None for g in groundings),
        source,
    )


def rated_corpus() -> Corpus:
    """The tiny corpus with who said its commands, and with judgments: it fills all files."""
    tiny = tiny_corpus()
    judgments = (Judgment(f"j{i}", "Go", "v", "w", "SA", f"rater {i}", "study") for i in range(20))
    return replace(
        tiny,
        commands={name: replace(c, subject="0123") for name, c in tiny.commands.items()},
        annotations=tuple(
            replace(a, command=replace(a.command, subject="0123")) for a in tiny.annotations
        ),
        judgments=tuple(judgments),
    )
