"""Authored corpora: trees of commands, the groundings of their clauses, and whether logs fit."""

from __future__ import annotations

import re
import zlib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored import authored_files
from corpus_tools.importers.authored.authored_files import Dataset, World, ends, read_world
from corpus_tools.importers.report import ImportReport, Journal
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.world.scenarios.documents import Document, read_document
from corpus_tools.world.scenarios.scenario import ROBOT
from corpus_tools.world.scenarios.scenario_files import SCENARIOS, Utterance
from corpus_tools.world.scenarios.scenario_reading import first_error, scenario_files, scenario_of
from g3.annotation import Annotation, Command, Source
from g3.errors import FormatError, SDCError
from g3.geometry.plane import convex_hull, point_gap
from g3.groundings import FloatArray, Grounding, PhysicalObject, Place
from g3.groundings import Path as Way
from g3.sdc.clauses import SDC, SDC_TYPES, breadth_first, child_indices
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
    """Groundings of each clause."""


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
    """Return the words of a leaf in lower case, without punctuation."""
    return [word.lower() for span in sdc.words for word in _WORD.findall(span.text)]


def fits_words(item: PhysicalObject, words: Sequence[str], dataset: Dataset) -> bool:
    """Check that an object has a label for each of the words that the dataset lists."""
    return all(
        not dataset.words[word] or not set(dataset.words[word]).isdisjoint(item.labels)
        for word in words
        if word in dataset.words
    )


def clause_names(sdcs: Sequence[SDC], nodes: Sequence[SDC]) -> tuple[str, ...]:
    """Name each clause as :func:`g3.sdc.sdc_notation.format_brackets` prints it."""
    printed = iter(_HEAD.findall(format_brackets(sdcs)))
    names = {id(sdc): next(printed) for sdc in _depth_first(sdcs)}
    return tuple(names.get(id(node), "") for node in nodes)


def _depth_first(sdcs: Sequence[SDC]) -> Iterator[SDC]:
    """Yield the clauses in the order in which they are printed; the unnamed robot is not."""
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
            log: Grounding = agent if event else Way(agent.trajectory)
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


GOAL_TOLERANCE_M = 0.5


def check_log(world: World) -> None:
    """Check that the log shows what the script says.

    FormatError if the robot, or what it moves, doesn't move or doesn't end in the place it should.
    """
    where = f"{SCENARIOS}/{world.scenario.id}.yaml: script"
    for thing in filter(None, (world.context.agent, world.moved)):
        if np.ptp(thing.trajectory.xyz, axis=0).max() == 0:
            raise FormatError(
                f"{thing.id} doesn't move in the log", where=where, fix="correct the scenario"
            )
    for name, place in ends(world.scenario).items():
        if _distance(world.objects[name], world.places[place]) > 0:
            raise FormatError(
                f"{name} doesn't end in {place} in the log", where=where, fix="make the way free"
            )


def check_clauses(clauses: Clauses, world: World) -> None:
    """Check that a command's groundings fit the log.

    A command that names loads names the load that moves. A PLACE of an EVENT is where what moves
    ends, or the robot. If they don't, the FormatError's ``where`` is the field.
    """
    nodes = list(breadth_first(clauses.sdcs))
    named = [
        item
        for sdc, groundings in zip(nodes, clauses.groundings, strict=True)
        for item in groundings
        if sdc.type == "OBJECT" and isinstance(item, PhysicalObject)
    ]
    loads = any("pallet" in item.labels for item in named)
    if world.moved is not None and loads and world.moved.id not in {item.id for item in named}:
        raise FormatError(
            f"{world.moved.id}, which moves in the log, is no clause's grounding",
            where="groundings",
            fix="correct the ids",
        )
    for sdc, below in zip(nodes, child_indices(clauses.sdcs), strict=True):
        if sdc.type != "EVENT":
            continue
        for child in (*below.get("l", ()), *below.get("l2", ())):
            if nodes[child].type == "PLACE":
                _check_goal(clauses, child, world)


def _check_goal(clauses: Clauses, node: int, world: World) -> None:
    ends = [item for item in (world.moved, world.context.agent) if item is not None]
    for place in clauses.groundings[node]:
        if not isinstance(place, Place):
            raise FormatError(
                f"{clauses.names[node]} is grounded in an object",
                where=f"groundings.{clauses.names[node]}",
                fix="give a place",
            )
        if min(_distance(item, place) for item in ends) > GOAL_TOLERANCE_M:
            raise FormatError(
                f"neither {' nor '.join(item.id for item in ends)} ends in the place of "
                f"{clauses.names[node]}",
                where=f"groundings.{clauses.names[node]}",
                fix="correct the place",
            )


def _distance(item: PhysicalObject, place: Place) -> float:
    """Metres from where an object ends to a place's footprint."""
    end: FloatArray = item.trajectory.xyz[None, -1:, :2]
    return float(point_gap(end, convex_hull(place.prism.xy)[None])[0, 0])


def generator(seed: int, command_id: str) -> np.random.Generator:
    """Make the generator of one command. Its draws don't depend on other commands."""
    return np.random.default_rng([seed, zlib.crc32(command_id.encode())])


def random_groundings(
    clauses: Clauses, world: World, worlds: Sequence[World], rng: np.random.Generator
) -> tuple[Groundings, ...]:
    """Draw as many random groundings for each clause as it has right ones.

    As in section 4.1 of the paper, they come from all scenarios. An EVENT or a PATH gets the log of
    another scenario than `world`, where the command was given; it stays without a grounding if
    there is none. The groundings of a plural come from one scenario.
    """
    others = [w for w in worlds if w is not world]
    drawn: list[Groundings] = []
    for sdc, groundings in zip(breadth_first(clauses.sdcs), clauses.groundings, strict=True):
        if not groundings:
            drawn.append(())
        elif sdc.type in ("EVENT", "PATH"):
            logs = [w.context.agent for w in others]
            chosen = [logs[int(rng.integers(len(logs)))]] if logs else []
            drawn.append(tuple(a if sdc.type == "EVENT" else Way(a.trajectory) for a in chosen))
        else:
            source = worlds[int(rng.integers(len(worlds)))].context
            pool: Sequence[Grounding] = source.places if sdc.type == "PLACE" else source.objects
            picks = rng.choice(len(pool), size=min(len(groundings), len(pool)), replace=False)
            drawn.append(tuple(pool[i] for i in sorted(picks)))
    return tuple(drawn)


def relabel(
    clauses: Clauses, drawn: Sequence[Groundings], dataset: Dataset
) -> tuple[bool | None, ...]:
    """Label random groundings as right or wrong, like a person who sees only the clause.

    A leaf OBJECT is right if every object fits each of its words, as dataset.yaml lists
    them. With a word that isn't listed (an ordinal, a side) only its own objects are
    right. An OBJECT with a relation and a PLACE are right if they and their landmarks are
    the right ones. An EVENT or a PATH, whose log is another scenario's, is wrong. A
    clause without groundings has no label.
    """
    nodes = list(breadth_first(clauses.sdcs))
    children = child_indices(clauses.sdcs)
    same = [_same(random, right) for random, right in zip(drawn, clauses.groundings, strict=True)]
    labels: list[bool | None] = []
    for i, (sdc, random) in enumerate(zip(nodes, drawn, strict=True)):
        if not random:
            labels.append(None)
        elif sdc.type in ("EVENT", "PATH"):
            labels.append(False)
        elif sdc.type == "OBJECT" and sdc.is_leaf:
            labels.append(same[i] or _denotes(sdc, random, dataset))
        else:
            landmarks = (*children[i].get("l", ()), *children[i].get("l2", ()))
            labels.append(same[i] and all(same[k] for k in landmarks))
    return tuple(labels)


def _denotes(leaf: SDC, groundings: Groundings, dataset: Dataset) -> bool:
    words = leaf_words(leaf)
    if not all(word in dataset.words for word in words):
        return False
    named = {label for word in words for label in dataset.words[word]}
    return all(
        isinstance(item, PhysicalObject)
        and fits_words(item, words, dataset)
        and (item.id != ROBOT or not named.isdisjoint(item.labels))
        for item in groundings
    )


def _same(a: Groundings, b: Groundings) -> bool:
    return len(a) == len(b) and all(any(_alike(x, y) for y in b) for x in a)


def _alike(a: Grounding, b: Grounding) -> bool:
    """Check that two things look the same: their first position and their kind."""
    if isinstance(a, PhysicalObject) and isinstance(b, PhysicalObject):
        return a.labels == b.labels and a.prism == b.prism
    return isinstance(a, Place) and isinstance(b, Place) and a.prism == b.prism


IMPORTER = "authored"
LOG_INTERVAL_S = 10_000.0
"""From the start of one scenario's log to that of the next."""


@dataclass(frozen=True, slots=True)
class _Grounded:
    """A command with its right groundings, and where it was given."""

    command: Command
    clauses: Clauses
    world: World


def import_authored(
    path: Path,
    *,
    salt: str = "",
    keep_going: bool = False,
    on_progress: OnProgress = no_progress,
) -> tuple[Corpus, ImportReport]:
    """Read an authored corpus: a folder with dataset.yaml, scenarios, layouts and logs.

    See :class:`corpus_tools.importers.importer_registry.ImportFunction`; datasets/warehouse is such
    a folder. FormatError if the corpus isn't there, or something in it can't be read.
    """
    journal = Journal(keep_going)
    dataset = authored_files.read_dataset(path, journal)
    files = list(scenario_files(path).values())
    grounded: list[_Grounded] = []
    worlds: list[World] = []
    for number, file in enumerate(files, start=1):
        on_progress("reading", number - 1, len(files))
        name = f"{SCENARIOS}/{file.name}"
        try:
            document = read_document(file, name)
            commands = authored_files.commands_of(document)
            authored_files.note_file(name, document.content, len(commands), journal)
            scenario = first_error(*scenario_of(document, file))
            world = read_world(path, scenario, number * LOG_INTERVAL_S, journal)
            check_log(world)
        except FormatError as error:
            place, _, field = error.where.partition(": ")
            journal.skip(place, "", FormatError(error.what, where=field, fix=error.fix))
            continue
        worlds.append(world)
        grounded += _read_commands(document, len(commands), world, dataset, journal)
    journal.check()
    if not grounded:
        raise FormatError(
            f"there is no command in {SCENARIOS}/*.yaml",
            where=str(path),
            fix="docs/authored-corpora.md describes the files",
        )
    corpus = Corpus.build(
        dataset.name,
        contexts=[world.context for world in worlds],
        commands=[item.command for item in grounded],
        annotations=[
            annotation for item in grounded for annotation in _annotations(item, worlds, dataset)
        ],
        source=f"{dataset.source} Seed of the random negatives: {dataset.seed}.",
        licence=dataset.licence,
    )
    return corpus, journal.report(IMPORTER, _counts(corpus, grounded), {})


def _read_commands(
    document: Document, count: int, world: World, dataset: authored_files.Dataset, journal: Journal
) -> list[_Grounded]:
    scenario = world.scenario
    found: list[_Grounded] = []
    for i in range(count):
        try:
            utterance = authored_files.read_utterance(document, i)
            clauses = read_clauses(utterance, world, dataset)
            check_clauses(clauses, world)
        except FormatError as error:
            line, _ = document.marks["commands", i]
            journal.skip(f"{document.name}:{line}", _title(document, i), error)
            continue
        command = Command(
            id=f"{scenario.id}-{i + 1:02}",
            text=utterance.text,
            scenario=scenario.id,
            video=scenario.id,
            subject=utterance.subject,
        )
        found.append(_Grounded(command, clauses, world))
    return found


def _title(document: Document, i: int) -> str:
    command = document.value["commands"][i]
    text = command.get("text") if isinstance(command, dict) else None
    return f"command {i + 1} ({text!r})"


def _annotations(
    item: _Grounded, worlds: Sequence[World], dataset: authored_files.Dataset
) -> tuple[Annotation, Annotation]:
    """Make the positive and the random negative annotation."""
    clauses = item.clauses
    drawn = random_groundings(clauses, item.world, worlds, generator(dataset.seed, item.command.id))
    right = tuple(True if groundings else None for groundings in clauses.groundings)

    def annotation(
        source: Source, groundings: tuple[Groundings, ...], correct: tuple[bool | None, ...]
    ) -> Annotation:
        name, context = f"{item.command.id}/{source}", item.world.context
        return Annotation(name, item.command, context, clauses.sdcs, groundings, correct, source)

    return (
        annotation("positive", clauses.groundings, right),
        annotation("random", drawn, relabel(clauses, drawn, dataset)),
    )


def _counts(corpus: Corpus, grounded: Sequence[_Grounded]) -> dict[str, int]:
    types = Counter(sdc.type for item in grounded for sdc in breadth_first(item.clauses.sdcs))
    return {
        "scenarios": len(corpus.contexts),
        "commands": len(corpus.commands),
        **{f"{name} clauses": types[name] for name in SDC_TYPES},
        "annotations": len(corpus.annotations),
    }
