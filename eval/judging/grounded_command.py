"""An annotated command's clauses and words in a world, and what they request.

Words are looked up in ``words.jsonl``, by their stems: each row has a meaning and an example.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.resources import files

import snowballstemmer

from eval.judging.execution import counterparts
from eval.judging.layout import Things
from g3.actions.robot_state import State
from g3.annotation import Annotation
from g3.geometry.relations import is_carrier
from g3.groundings import PhysicalObject, Place
from g3.sdc.clauses import SDC, Field, Span, all_words, breadth_first, child_indices
from g3.short_repr import short_repr

HANDLING = frozenset({"take", "put", "carry"})
VERBS = HANDLING | {"go", "turn", "stay"}
SIDES = frozenset({"left", "right", "front", "back"})
_ENDS = frozenset({"to", "on", "near", "toward", "end"})
_PUNCTUATION = "\"`.,;:!?()[]{}<>*-'’"
_STEMMER = snowballstemmer.stemmer("english")


@cache
def _word_table() -> dict[str, frozenset[str]]:
    """Return the meanings of each stem."""
    table: dict[str, set[str]] = {}
    for line in (files("eval.judging") / "words.jsonl").read_text(encoding="utf-8").splitlines():
        row = json.loads(line)
        for word in row["words"].split():
            table.setdefault(stem(word), set()).add(row["means"])
    return {word: frozenset(meanings) for word, meanings in table.items()}


@cache
def stem(word: str) -> str:
    """Return a word in lower case, without its ending and the punctuation around it."""
    return str(_STEMMER.stemWord(word.strip(_PUNCTUATION).lower()))


def meanings(words: Iterable[Span]) -> frozenset[str]:
    """Return the meanings of words, by the table."""
    table = _word_table()
    return frozenset(m for word in words for m in table.get(stem(word.text), ()))


@short_repr
@dataclass(frozen=True)
class GroundedCommand:
    """A command's clauses, breadth first, with their groundings in a world."""

    sdcs: Sequence[SDC]
    """The top-level clauses."""
    state: State
    """The world before anything is done."""
    own: bool
    """True if this is the annotated world."""
    annotated: Sequence[Things]
    """Annotated object ids of each clause."""
    things: Sequence[Things]
    """Ids of the same objects in this world, where they exist in it."""
    labels: Sequence[frozenset[tuple[str, ...]]]
    """Labels of these objects, for each clause."""
    places: Sequence[tuple[Place, ...]]
    """Annotated regions of each clause."""
    by_labels: bool = False
    """True if nobody has grounded it, so that each noun names one thing with its labels."""

    @cached_property
    def nodes(self) -> list[SDC]:
        """All clauses."""
        return list(breadth_first(self.sdcs))

    @cached_property
    def children(self) -> list[dict[Field, tuple[int, ...]]]:
        """The clauses in the fields of each."""
        return child_indices(self.sdcs)

    @property
    def robot(self) -> str:
        """Id of the robot in the world."""
        return self.state.context.agent_id

    def meanings(self, node: int) -> frozenset[str]:
        """Return the meanings of a clause's relation, or of a leaf's words."""
        return meanings(self.nodes[node].relation or self.nodes[node].words)

    def below(self, node: int, *types: str) -> list[int]:
        """Return the clauses of some types that are landmarks of a clause."""
        marks = (n for field in ("l", "l2") for n in self.children[node].get(field, ()))
        return [n for n in marks if self.nodes[n].type in types and not self.nodes[n].is_implicit]

    def figures(self, node: int) -> list[int]:
        """Return an OBJECT, and those in it that name the same in fewer words."""
        chain = [node]
        for n in chain:
            chain += [
                c for c in self.children[n].get("f", ())[:1] if self.nodes[c].type == "OBJECT"
            ]
        return chain

    def is_robot(self, node: int) -> bool:
        """Check that a clause names the robot or a part of it."""
        if self.annotated[node]:
            return self.robot in self.things[node]
        return self.nodes[node].is_leaf and "robot" in self.meanings(node)

    def is_carrier(self, node: int) -> bool:
        """Check that a clause names things that carry loads."""
        shapes = [self.state.thing(i).prism for i in self.things[node]]
        return bool(shapes) and all(map(is_carrier, shapes))

    def is_pronoun(self, node: int) -> bool:
        """Check that an OBJECT is a pronoun."""
        words = self.nodes[node].words
        return len(words) == 1 and "pronoun" in meanings(words)

    def is_area(self, node: int) -> bool:
        """Check that an OBJECT is a place: "the floor", "the space between the pallets"."""
        sdc, noun = self.nodes[node], self.nodes[self.figures(node)[-1]]
        kinds = meanings(noun.words)
        located = sdc.landmark1 and not self.names_same(node)
        return sdc.type == "OBJECT" and ("ground" in kinds or bool(located and "area" in kinds))

    def names_same(self, node: int) -> bool:
        """Check that a landmark names the same thing once more: "the pallet of tires"."""
        marks = self.below(node, "OBJECT", "PLACE", "PATH", "EVENT")
        same = all(self.annotated[n] == self.annotated[node] for n in marks)
        if [stem(w.text) for w in self.nodes[node].relation] == ["of"]:
            return True
        is_named = bool(self.annotated[node]) and "alone" not in self._mark_meanings(marks)
        return is_named and bool(marks) and same

    def _mark_meanings(self, marks: Iterable[int]) -> frozenset[str]:
        return frozenset(m for n in marks for m in self.meanings(n))

    def alike(self, node: int) -> Things:
        """Return things that an OBJECT's noun names as well as its groundings.

        A noun that consists of labels names all things with these labels: "the pallet of tires" any
        pallet of tires, "the pallet" any pallet. Another noun names things with all the labels of
        its groundings.
        """
        noun: set[str] = set()
        for n in self.figures(node):
            leaves = self.below(n, "OBJECT") if self.names_same(n) else []
            for leaf in (self.figures(m)[-1] for m in (n, *leaves)):
                noun |= {stem(w.text) for w in self.nodes[leaf].words if not meanings([w])}
        return named(self.state, noun, self.labels[node])


def named(state: State, noun: Iterable[str], kinds: Iterable[tuple[str, ...]]) -> Things:
    """Return things of some kinds, or of all kinds with the labels that a noun's stems name."""
    noun, alike = frozenset(noun), set[str]()
    others = [o for o in state.context.objects if o.id != state.context.agent_id]
    for labels in kinds:
        by_stem = {stem(label): label for label in labels}
        matching = {by_stem[w] for w in noun} if noun and noun <= by_stem.keys() else set(labels)
        alike |= {o.id for o in others if matching <= set(o.labels)}
    return frozenset(alike)


def grounded_command(annotation: Annotation, start: State) -> GroundedCommand:
    """Ground a command's annotation in the start state of a world."""
    context, world = annotation.context, start.context
    same = context.id == world.id
    now = {o.id: o.id for o in context.objects} if same else counterparts(context, world)
    now[context.agent_id] = world.agent_id
    groundings = [
        group if right is not False else ()
        for group, right in zip(annotation.groundings, annotation.correct, strict=True)
    ]
    things = [[g for g in group if isinstance(g, PhysicalObject)] for group in groundings]
    return GroundedCommand(
        annotation.sdcs,
        start,
        same,
        [frozenset(o.id for o in group) for group in things],
        [frozenset(now[o.id] for o in group if o.id in now) for group in things],
        [frozenset(o.labels for o in group if o.id != context.agent_id) for group in things],
        [tuple(g for g in group if isinstance(g, Place)) for group in groundings],
    )


def grounded_clauses(sdcs: Sequence[SDC], start: State) -> GroundedCommand:
    """Ground clauses without annotations: nouns name the things with these labels.

    Each names one thing. A pronoun names what the OBJECT before it does.
    """
    nodes, children = list(breadth_first(sdcs)), child_indices(sdcs)
    kinds = {o.labels for o in start.context.objects if o.id != start.context.agent_id}
    leaves = sorted((n for n, sdc in enumerate(nodes) if sdc.words), key=lambda n: nodes[n].words)
    things: list[Things] = [frozenset()] * len(nodes)
    before: Things = frozenset()
    for n in leaves:
        words = nodes[n].words
        noun = {stem(w.text) for w in words if not meanings([w])}
        if "robot" in meanings(words) and not noun:
            things[n] = frozenset({start.context.agent_id})
        elif noun:
            fitting = [labels for labels in kinds if noun <= {stem(label) for label in labels}]
            things[n] = before = named(start, noun, fitting) if fitting else frozenset()
        elif "pronoun" in meanings(words):
            things[n] = before
    for n in reversed(range(len(nodes))):
        if children[n].get("f") and nodes[n].type == "OBJECT":
            things[n] = things[children[n]["f"][0]]
    of_thing = {o.id: o.labels for o in start.context.objects if o.id != start.context.agent_id}
    labels = [frozenset(of_thing[i] for i in ids if i in of_thing) for ids in things]
    places = [
        tuple(p for p in start.context.places if sdc.words and _is_named(p, sdc.words))
        for sdc in nodes
    ]
    return GroundedCommand(sdcs, start, False, things, things, labels, places, by_labels=True)


def _is_named(place: Place, words: Iterable[Span]) -> bool:
    return set(place.name.lower().split()) <= {w.text.lower() for w in words} and bool(place.name)


@short_repr
@dataclass(frozen=True, slots=True)
class Request:
    """An EVENT that asks for something to be done."""

    verbs: frozenset[str]
    """Meanings of its verb."""
    sides: frozenset[str]
    """Sides that it names without a landmark: "turn left"."""
    handles: bool
    """True if it is about a load; otherwise the robot drives."""
    themes: tuple[Things, ...]
    """Loads to handle, as annotated; empty if it names none, and none was named before."""
    goals: tuple[int, ...]
    """Clauses that state where the load, or the robot, is to end."""
    sources: tuple[int, ...]
    """Clauses that state where the load is taken from."""
    passed: tuple[int, ...]
    """Clauses that state landmarks for the robot to pass."""
    is_clear: bool
    """False if it handles something that nobody has grounded."""


def requests(command: GroundedCommand) -> list[Request]:
    """Return what a command requests, in order."""
    result: list[Request] = []
    spoken: tuple[Things, ...] = ()
    for event in (n for root in range(len(command.sdcs)) for n in _events(command, root)):
        request = _request(command, event, spoken)
        if request is not None:
            result.append(request)
            spoken = request.themes or spoken
    return result


def _events(command: GroundedCommand, node: int) -> Iterator[int]:
    """Yield EVENTs with known verbs: of "use the forks to lift it" the inner one."""
    says = command.meanings(node)
    if command.nodes[node].type != "EVENT" or "not" in says:
        return
    if says & VERBS:
        yield node
    for inner in command.below(node, "EVENT"):
        if "until" not in command.meanings(inner):
            yield from _events(command, inner)


def _request(command: GroundedCommand, event: int, spoken: tuple[Things, ...]) -> Request | None:
    says = command.meanings(event)
    verbs = says & VERBS
    figures = command.children[event].get("f", ())
    subjects = [n for n in figures if not (command.nodes[n].is_implicit or command.is_robot(n))]
    objects = [n for n in (*subjects, *command.below(event, "OBJECT")) if not command.is_area(n)]
    named = [n for n in objects if command.annotated[n] and not command.is_robot(n)]
    loads = [n for n in named if not command.is_carrier(n)]
    about_robot = any(command.is_robot(n) for n in objects)
    forks = any("forks" in meanings(all_words(command.nodes[n])) for n in objects)
    held = command.state.held is not None
    sides, goals, sources, passed = _where(command, event)
    if named or about_robot:
        is_subject = bool(goals) and any(n in loads for n in subjects)
        handles = bool(loads) and bool(verbs & HANDLING or "with" in says or is_subject)
        handles |= forks and not (loads or goals) and bool(verbs & {"take", "put"})
    else:
        handles = bool(verbs & {"take", "put"} or (verbs & HANDLING and (spoken or held)))
        handles &= not verbs & {"go", "turn", "stay"}
    themes: tuple[Things, ...] = ()
    if handles:
        # What a clause doesn't name is what was spoken of before: "deposit there".
        themes = tuple(command.annotated[n] for n in loads[:1]) or spoken
    if not handles:
        passed += tuple(n for n in goals if not _leads_to(command, n))
        goals = tuple(n for n in goals if n not in passed)
        goals = goals or (tuple(named) if "to" in says else ())
        passed = passed or (tuple(named) if "past" in says else ())
    elif not goals and loads and len(named) > len(loads):
        carriers = tuple(n for n in named if n not in loads)
        goals, sources = (goals, carriers) if verbs == {"take", "put"} else (carriers, sources)
    if (handles and says & {"alone"}) or (
        verbs == {"put"} and not held and not spoken and not goals
    ):
        return None  # "leave it alone"
    is_clear = bool(named or about_robot or forks or not (handles and objects))
    return Request(verbs, sides, handles, themes, goals, sources, passed, is_clear)


def _where(
    command: GroundedCommand, event: int
) -> tuple[frozenset[str], tuple[int, ...], tuple[int, ...], tuple[int, ...]]:
    """Return a clause's sides, goals, sources, and what is passed."""
    sides = command.meanings(event) & SIDES
    leads = command.below(event, "PATH", "PLACE")
    leads += [n for n in command.below(event, "OBJECT") if command.is_area(n)]
    for inner in command.below(event, "EVENT"):
        if "until" in command.meanings(inner):
            leads += command.below(inner, "PATH", "PLACE", "OBJECT")
    goals: list[int] = []
    sources: list[int] = []
    passed: list[int] = []
    for n in leads:
        says, is_bare = command.meanings(n), not command.nodes[n].landmark1
        sides |= says & SIDES if is_bare else frozenset()
        if "there" in says and is_bare:
            continue
        kinds = goals if says & _ENDS else sources if "from" in says else passed
        (kinds if says & {"from", "past"} else goals).append(n)
    return sides, tuple(goals), tuple(sources), tuple(passed)


def _leads_to(command: GroundedCommand, node: int) -> bool:
    """Check that a clause states where the robot ends, not on which way it drives."""
    says = command.meanings(node)
    is_place = command.nodes[node].type != "PATH"
    return bool(says & _ENDS) or (is_place and bool(command.nodes[node].landmark1))
