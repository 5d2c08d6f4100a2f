"""Trees of commands, and the groundings of their clauses."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from corpus_tools.importers.authored.authored_files import Dataset
from corpus_tools.importers.authored.authored_worlds import World
from corpus_tools.world.scenarios.scenario_files import Utterance
from g3.errors import FormatError, SDCError
from g3.groundings import Grounding, Path, PhysicalObject
from g3.sdc.clauses import SDC, breadth_first
from g3.sdc.sdc_notation import format_brackets, has_implicit_figure, parse_brackets
from g3.short_repr import short_repr

Groundings = tuple[Grounding, ...]

_HEAD = re.compile(r"\b((?:EVENT|OBJ|PLACE|PATH)_[0-9]+)\(")
_WORD = re.compile(r"[\w']+")


@short_repr
@dataclass(frozen=True, slots=True)
class Clauses:
    """A command's clauses, breadth first, with their right groundings."""

    sdcs: tuple[SDC, ...]
    names: tuple[str, ...]
    """For each clause its name in the notation, such as OBJ_2; empty for the unnamed robot of an
    imperative."""
    groundings: tuple[Groundings, ...]
    """For each clause what it is grounded in."""


def read_clauses(utterance: Utterance, world: World, dataset: Dataset) -> Clauses:
    """Read a command's trees and ground their clauses.

    An EVENT is grounded in the robot with its log, and a PATH in the robot's path (section 4.1 of
    the paper). The author may say that it has no grounding. An OBJECT with a figure is grounded in
    what its figure is, unless the author says otherwise. What is not right is a FormatError whose
    ``where`` is the field.
    """
    try:
        sdcs = parse_brackets(utterance.sdcs, command=utterance.text)
    except SDCError as error:
        where = f"sdcs: {error.where}" if error.where else "sdcs"
        raise FormatError(error.what, where=where, fix=error.fix) from error
    nodes = list(breadth_first(sdcs))
    names = clause_names(sdcs, nodes)
    given = tuple(_HEAD.findall(utterance.sdcs))
    printed = sorted(filter(None, names), key=lambda name: int(name.partition("_")[2]))
    if list(given) != printed:
        raise FormatError(
            "the clauses are not numbered as in the paper",
            where="sdcs",
            fix=f"write {format_brackets(sdcs)!r}",
        )
    for name in utterance.groundings:
        if name not in names:
            known = sorted(filter(None, names))
            raise FormatError.unknown("clause", name, known, where=f"groundings.{name}")
    return Clauses(sdcs, names, _ground(nodes, names, utterance, world, dataset))


def leaf_words(sdc: SDC) -> list[str]:
    """The words of a leaf in lower case, without punctuation."""
    return [word.lower() for span in sdc.words for word in _WORD.findall(span.text)]


def fits_words(item: PhysicalObject, words: Sequence[str], dataset: Dataset) -> bool:
    """Whether an object has the labels that those of the words which are listed call for."""
    return all(
        not dataset.words[word] or not set(dataset.words[word]).isdisjoint(item.labels)
        for word in words
        if word in dataset.words
    )


def clause_names(sdcs: Sequence[SDC], nodes: Sequence[SDC]) -> tuple[str, ...]:
    """The name of each clause as :func:`g3.sdc.sdc_notation.format_brackets` prints it."""
    printed = iter(_HEAD.findall(format_brackets(sdcs)))
    names = {id(sdc): next(printed) for sdc in _depth_first(sdcs)}
    return tuple(names.get(id(node), "") for node in nodes)


def _depth_first(sdcs: Sequence[SDC]) -> Iterator[SDC]:
    """The clauses in the order in which they are printed; the unnamed robot is not."""
    for sdc in sdcs:
        yield sdc
        children = sdc.children()
        yield from _depth_first(children[1:] if has_implicit_figure(sdc) else children)


def _ground(
    nodes: Sequence[SDC],
    names: Sequence[str],
    utterance: Utterance,
    world: World,
    dataset: Dataset,
) -> tuple[Groundings, ...]:
    found: dict[int, Groundings] = {}
    # Backwards, so that figures are grounded before the clauses that they are in.
    for node, name in zip(reversed(nodes), reversed(names), strict=True):
        where = f"groundings.{name}"
        given = utterance.groundings.get(name)
        if not name:
            groundings: Groundings = ()
        elif node.type in ("EVENT", "PATH"):
            if given:
                raise FormatError(
                    f"{name} is grounded in the log", where=where, fix="leave it out or give []"
                )
            agent = world.context.agent
            event = node.type == "EVENT"
            log: Grounding = agent if event else Path(agent.trajectory)
            groundings = () if given is not None else (log,)
        elif given is not None:
            ids = (given,) if isinstance(given, str) else given
            groundings = tuple(_lookup(item, world, where) for item in ids)
        elif node.type == "OBJECT" and node.figure:
            groundings = tuple(g for child in node.figure for g in found[id(child)])
        else:
            raise FormatError(
                f"{name} has no grounding", where=where, fix="name an object or a place, or give []"
            )
        if node.type == "OBJECT" and node.is_leaf:
            _check_words(node, groundings, dataset, where)
        found[id(node)] = groundings
    return tuple(found[id(node)] for node in nodes)


def _lookup(item: str, world: World, where: str) -> Grounding:
    known: dict[str, Grounding] = {**world.objects, **world.places}
    if item not in known:
        raise FormatError.unknown("object or place", item, known, where=where)
    return known[item]


def _check_words(leaf: SDC, groundings: Groundings, dataset: Dataset, where: str) -> None:
    for item in groundings:
        words = leaf_words(leaf)
        if isinstance(item, PhysicalObject) and not fits_words(item, words, dataset):
            raise FormatError(
                f"{' '.join(words)!r} can't be {item.id}, which is {', '.join(item.labels)}",
                where=where,
                fix="correct the id, or the words in dataset.yaml",
            )
