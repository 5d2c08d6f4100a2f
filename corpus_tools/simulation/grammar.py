"""A grammar of simulated workers' commands for the robot's actions.

The robot's script is cut into what it gets and what it does with it. Each has several plans: one
clause for both ("Put the tires on the truck"), or a clause for each ("Go to the tires, pick them
up, and put them on the truck"), with verbs whose particle may stand apart.

To refer to a thing a worker takes a noun that fits, and sees which other things it fits as well.
Then they add something that is true of the thing meant alone: its colour or height, what it stands
on or next to, or its order in the row as the robot sees it. A vague worker leaves that out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from corpus_tools.world.scenarios.contexts import scenario_context
from corpus_tools.world.scenarios.scenario import ROBOT, Scenario
from corpus_tools.world.state.robot_script import DRIVE_TO
from corpus_tools.world.state.thing_kinds import KINDS
from g3.actions.forklift_actions import DRIVE_PAST, PICK_UP, PUT_DOWN
from g3.errors import CorpusError
from g3.geometry.plane import rotate
from g3.groundings import Colour, FloatArray, Prism
from g3.sdc.clauses import SDC, SDCType, Span
from g3.short_repr import short_repr

POLITE = ("please", "could you please", "i need you to")
_ROWS = ("qwertyuiop", "asdfghjkl", "zxcvbnm")
_SHORTEST = 4
"""Shorter words are typed right."""


@short_repr
@dataclass(frozen=True, slots=True)
class Seen:
    """A thing or a place as the robot's driver sees it at the start."""

    id: str
    kind: str
    """Kind of a thing; empty for a place."""
    labels: frozenset[str]
    name: str
    """Name of a place on the map."""
    deck: str
    """Id of its support; empty for the ground."""
    at: tuple[float, float]
    """Metres ahead of the robot and to its left."""
    height: float
    colours: tuple[Colour, ...] = ()
    """Colours of its paint; none for the usual look of its kind."""


@short_repr
@dataclass(frozen=True, slots=True)
class Scene:
    """All that can be seen, by id."""

    scenario: Scenario
    things: Mapping[str, Seen]
    places: Mapping[str, Seen]
    """Things and places in view; the robot's load is not among the things."""


def see(scenario: Scenario) -> Scene:
    """Return a scenario as it looks from the robot's start."""
    context = scenario_context(scenario)
    start = context.agent.trajectory
    pose = (start.xyz[0, :2], float(start.yaw[0]))
    objects, regions = scenario.all_objects, scenario.all_places
    things = {
        item.id: Seen(
            item.id,
            objects[item.id].kind,
            frozenset(KINDS[objects[item.id].kind].labels),
            "",
            objects[item.id].deck or "",
            _from(pose, item.prism),
            item.prism.z_max - item.prism.z_min,
            item.colours,
        )
        for item in context.objects
        if item.id not in (ROBOT, scenario.robot.carries)
    }
    places = {
        name: Seen(
            name,
            "",
            frozenset(),
            regions[name].name,
            regions[name].deck or "",
            _from(pose, place),
            place.z_max - place.z_min,
        )
        for name, place in zip(regions, (p.prism for p in context.places), strict=True)
    }
    return Scene(scenario, things, places)


def distance(a: Seen, b: Seen) -> float:
    """Return the distance between the middles of two things, in metres."""
    return float(np.hypot(a.at[0] - b.at[0], a.at[1] - b.at[1]))


def _from(pose: tuple[FloatArray, float], prism: Prism) -> tuple[float, float]:
    position, yaw = pose
    ahead, left = rotate(prism.xy.mean(axis=0) - position, np.asarray(-yaw))
    return float(ahead), float(left)


@dataclass(frozen=True, slots=True)
class Worker:
    """Habits of a simulated worker."""

    id: str
    """Identifier, which marks the worker as simulated."""
    misspelling: float
    """Probability that a word of four letters or more is misspelt."""
    vagueness: float
    """Probability that a phrase may fit other things too."""
    politeness: float
    """Probability of an introduction."""
    capitals: bool
    full_stop: bool
    """True if sentences begin with a capital, and end with a full stop."""


def draw_workers(count: int, seed: int) -> tuple[Worker, ...]:
    """Draw workers; the first are the same for any number of them.

    Misspelling is Beta(1, 30), vagueness Beta(2, 10), politeness Beta(1, 4); two in three
    use capitals and full stops.
    """
    return tuple(_draw(number, np.random.default_rng([seed, number])) for number in range(count))


def _draw(number: int, rng: np.random.Generator) -> Worker:
    return Worker(
        id=f"simulated-{number:04}",
        misspelling=float(rng.beta(1, 30)),
        vagueness=float(rng.beta(2, 10)),
        politeness=float(rng.beta(1, 4)),
        capitals=bool(rng.random() < 2 / 3),
        full_stop=bool(rng.random() < 2 / 3),
    )


def misspell(word: str, rng: np.random.Generator) -> str:
    """Return a word with one slip: a letter left out, doubled, swapped, or a key beside."""
    if len(word) < _SHORTEST or not word.isalpha():
        return word
    at = int(rng.integers(1, len(word) - 1))
    before, letter, after = word[:at], word[at], word[at + 1 :]
    slip = int(rng.integers(4))
    if slip == 0:
        return before + after
    if slip == 1:
        return before + letter + letter + after
    if slip == 2:
        return before + after[0] + letter + after[1:]
    return before + _beside(letter, rng) + after


def _beside(letter: str, rng: np.random.Generator) -> str:
    row = next((row for row in _ROWS if letter in row), letter)
    at = row.index(letter)
    near = row[max(0, at - 1) : at] + row[at + 1 : at + 2]
    return near[int(rng.integers(len(near)))] if near else letter


Spell: TypeAlias = Callable[[str], str]
"""Spelling of a word by a worker."""


@short_repr
@dataclass(slots=True)
class Wording:
    """A command as it is typed."""

    spell: Spell = str
    """Spelling of each word."""
    capitals: bool = False
    """True if sentences begin with one."""
    text: str = ""
    """Text typed so far."""
    groundings: dict[int, tuple[SDC, tuple[str, ...]]] = field(default_factory=dict)
    """Ids of what clauses are grounded in, by the identity of the clause, which is kept too."""

    def say(self, words: str) -> tuple[Span, ...]:
        """Type words, and return where they stand."""
        spans = []
        for word in words.split():
            typed = self.spell(word)
            if self.capitals and (not self.text or self.text.endswith(".")):
                typed = typed[0].upper() + typed[1:]
            self.text += " " if self.text else ""
            spans.append(Span(len(self.text), typed))
            self.text += typed
        return tuple(spans)

    def mark(self, sign: str) -> None:
        """Type a punctuation mark right after the last word."""
        self.text += sign

    def ground(self, clause: SDC, *ids: str) -> SDC:
        """Note a clause's groundings, and return it."""
        self.groundings[id(clause)] = (clause, ids)
        return clause

    def grounding(self, clause: SDC) -> tuple[str, ...] | None:
        """Return ids of groundings of a clause; None if none were noted."""
        noted = self.groundings.get(id(clause))
        return None if noted is None else noted[1]

    def leaf(self, words: str, *ids: str) -> SDC:
        """Type a leaf OBJECT."""
        return self.ground(SDC("OBJECT", words=self.say(words)), *ids)


def clause(
    type_: SDCType,
    relation: tuple[Span, ...],
    *landmarks: SDC,
    figure: SDC | None = None,
) -> SDC:
    """Return an internal clause; an EVENT without a figure is an imperative without its agent."""
    if figure is None and type_ == "EVENT":
        figure = SDC("OBJECT")
    return SDC(
        type_,
        relation=relation,
        figure=() if figure is None else (figure,),
        landmark1=landmarks[:1],
        landmark2=landmarks[1:],
    )


PICK = ("pick up", "lift", "get", "grab", "lift up")
PLACE_VERBS = ("put", "place", "set", "leave")
TAKE = ("take", "bring", "move", "carry")
GO = ("go", "drive", "head", "move")
JOINS = (" and", ", then", ".")
LOOSE = ("pick up", "lift up", "put down", "set down")
"""Verbs whose particle may come after the object."""

Sayer: TypeAlias = Callable[["_Speaker"], SDC]


@short_repr
@dataclass(frozen=True, slots=True)
class Told:
    """A command."""

    sdcs: tuple[SDC, ...]
    wording: Wording
    """Its text, and what clauses are grounded in. Those of which it knows nothing are grounded by
    the log, or by their figure."""


def tell(scene: Scene, worker: Worker, rng: np.random.Generator) -> Told:
    """Return a worker's command for a scene's events; CorpusError for an action without words."""

    def spell(word: str) -> str:
        return misspell(word, rng) if rng.random() < worker.misspelling else word

    wording = Wording(spell, worker.capitals)
    speaker = _Speaker(scene, worker, rng, wording)
    if rng.random() < worker.politeness:
        wording.say(speaker.one_of(POLITE))
    clauses: list[SDC] = []
    for say in speaker.plan():
        if clauses:
            speaker.join()
        clauses.append(say(speaker))
    if worker.full_stop:
        wording.mark(".")
    return Told(tuple(clauses), wording)


@dataclass(slots=True)
class _Speaker:
    """A worker at work on one command."""

    scene: Scene
    worker: Worker
    rng: np.random.Generator
    wording: Wording
    named: str = ""
    """The load, once it has been named."""

    def one_of(self, forms: Sequence[str]) -> str:
        return forms[int(self.rng.integers(len(forms)))]

    def join(self) -> None:
        sign = self.one_of(JOINS)
        self.wording.mark(sign.split(" ", maxsplit=1)[0])
        self.wording.say(sign.lstrip(",."))

    def plan(self) -> list[Sayer]:
        """Return the wording of the script, a sayer for each clause."""
        held = self.scene.scenario.robot.carries or ""
        plan: list[Sayer] = []
        steps = list(self.scene.scenario.script)
        while steps:
            step = steps.pop(0)
            goal = str(step.argument)
            if step.kind is PICK_UP:
                held = goal
                put = steps.pop(0) if steps and steps[0].kind is PUT_DOWN else None
                plan += self._fetch(held, "" if put is None else str(put.argument))
                held = held if put is None else ""
            elif step.kind is PUT_DOWN:
                plan.append(_put(held, goal))
                held = ""
            elif step.action == DRIVE_TO.name:
                plan.append(_take(held, goal) if held and self.rng.random() < 0.5 else _go(goal))
            elif step.kind is not None and step.kind.aims:
                plan.append(_move(goal, past=step.kind is DRIVE_PAST))
            else:
                raise CorpusError(
                    f"no simulated worker has words for {step.action}",
                    where=self.scene.scenario.id,
                    fix="use scenarios of `ct scenarios generate`",
                )
        return plan

    def _fetch(self, load: str, goal: str) -> list[Sayer]:
        """Return sayers for getting a load and bringing it to its goal, in one to three clauses."""
        first: list[Sayer] = [_go_to_thing(load)] if self.rng.random() < 0.2 else []
        if not goal:
            return [*first, _pick(load)]
        if not first and self.rng.random() < 0.6:
            region = self.scene.places[goal]
            taken = (region.name or region.deck) and self.rng.random() < 0.5
            return [_take(load, goal) if taken else _put(load, goal)]
        return [*first, _pick(load), _put(load, goal)]

    def short(self, load: str) -> str:
        """Return a pronoun or the like for a load on the forks or named before; else empty."""
        if load not in self.scene.things:
            return self.one_of(("it", "the load", "your load"))
        return "it" if self.named == load else ""

    def load(self, id_: str, short: str) -> SDC:
        """Type the load, in short or with a phrase, and return its clause."""
        if short:
            return self.wording.leaf(short, id_)
        self.named = id_
        return self.thing(self.scene.things[id_])

    def thing(self, thing: Seen) -> SDC:
        vague = bool(self.rng.random() < self.worker.vagueness)
        return refer(self.wording, self.scene, thing, self.rng, vague=vague)

    def event(self, verb: str, load: str, goal: Callable[[], SDC] | None = None) -> SDC:
        """Type an EVENT of a load; its verb's particle may follow a noun, and follows pronouns."""
        words = verb.split()
        short = self.short(load)
        apart = verb in LOOSE and (short == "it" or self.rng.random() < 0.4)
        relation = self.wording.say(words[0] if apart else verb)
        landmark = self.load(load, short)
        if apart:
            relation += self.wording.say(words[1])
        return clause("EVENT", relation, landmark, *([] if goal is None else [goal()]))

    def place(self, id_: str) -> SDC:
        """Type the PLACE where something is put, and return its clause."""
        place = self.scene.places[id_]
        if place.name and not place.deck:
            inside = self.wording.say(self.one_of(("in", "inside")))
            landmark = name_place(self.wording, place, self.rng)
            return self.wording.ground(clause("PLACE", inside, landmark), id_)
        if place.deck:
            relations = ("on", "onto", "on top of")
            about = self.scene.things[place.deck]
        else:
            relations = ("next to", "beside", "near")
            others = (t for t in self.scene.things.values() if t.id != self.named)
            about = min(others, key=lambda thing: distance(place, thing))
        relation = self.wording.say(self.one_of(relations))
        return self.wording.ground(clause("PLACE", relation, self.thing(about)), id_)

    def path(self, relations: Sequence[str], goal: str) -> SDC:
        """Type the PATH to or past a place, a carrier or a thing, and return its clause."""
        relation = self.wording.say(self.one_of(relations))
        place = self.scene.places.get(goal)
        if place is not None and place.name:
            return clause("PATH", relation, name_place(self.wording, place, self.rng))
        thing = self.scene.things[goal if place is None else place.deck]
        return clause("PATH", relation, self.thing(thing))


def _pick(load: str) -> Sayer:
    return lambda s: s.event(s.one_of(PICK), load)


def _put(load: str, goal: str) -> Sayer:
    def say(s: _Speaker) -> SDC:
        verb = s.one_of(("put down", "set down") if s.rng.random() < 0.2 else PLACE_VERBS)
        return s.event(verb, load, lambda: s.place(goal))

    return say


def _take(load: str, goal: str) -> Sayer:
    return lambda s: s.event(s.one_of(TAKE), load, lambda: s.path(("to", "over to"), goal))


def _go(goal: str) -> Sayer:
    return lambda s: clause("EVENT", s.wording.say(s.one_of(GO)), s.path(("to", "over to"), goal))


def _go_to_thing(load: str) -> Sayer:
    def say(s: _Speaker) -> SDC:
        relation = s.wording.say(s.one_of(GO))
        to = s.wording.say(s.one_of(("to", "over to", "up to")))
        return clause("EVENT", relation, clause("PATH", to, s.load(load, "")))

    return say


def _move(goal: str, *, past: bool) -> Sayer:
    relations = ("past", "by") if past else ("up to", "to", "over to")
    return lambda s: clause("EVENT", s.wording.say(s.one_of(GO)), s.path(relations, goal))


CLEARLY_M = 1.0
"""Least distance by which a thing lies further to a side, or nearer, in metres."""
CLEARLY_TALLER = 1.2
"""Least ratio of a tall thing's height to that of one that is not tall."""
BY_M = 4.0
"""Largest distance from a landmark of a thing "next to" it, in metres."""


@short_repr
@dataclass(frozen=True, slots=True)
class Noun:
    """A way to name a kind of thing."""

    labels: frozenset[str]
    """Labels that a thing must have for the noun to fit."""
    head: str
    """The noun, without an article."""
    of: str = ""
    """Load of the thing, as in "pallet of tires"; empty if the noun doesn't name it."""


def _nouns(labels: Sequence[str], *names: str) -> tuple[Noun, ...]:
    nouns = []
    for name in names:
        head, _, of = name.partition(" of ")
        nouns.append(Noun(frozenset(labels), head, of))
    return tuple(nouns)


_PALLET = _nouns(("pallet",), "pallet", "skid")
NOUNS = {
    "tire-pallet": (
        *_nouns(("tire", "pallet"), "tire pallet", "pallet of tires", "skid of tires", "tires"),
        *_PALLET,
    ),
    "box-pallet": (
        *_nouns(("box", "pallet"), "box pallet", "pallet of boxes", "boxes"),
        *_PALLET,
    ),
    "crate": _nouns(("crate",), "crate"),
    "truck": _nouns(("truck",), "truck", "lorry"),
    "trailer": _nouns(("trailer",), "trailer", "flatbed"),
    "shelf": _nouns(("shelf",), "shelf"),
    "barrel": _nouns(("barrel",), "barrel"),
    "person": _nouns(("person",), "person", "man", "worker"),
    "cone": _nouns(("cone",), "cone"),
}
"""Nouns for each kind; the first names are no commoner than the others."""

_ORDINALS = ("first", "second", "third", "fourth", "fifth")


def refer(
    wording: Wording, scene: Scene, thing: Seen, rng: np.random.Generator, *, vague: bool
) -> SDC:
    """Type a phrase for a thing, and return its OBJECT clause.

    A `vague` worker doesn't care if the phrase fits other things too.
    """
    nouns = NOUNS[thing.kind]
    noun = nouns[int(rng.integers(len(nouns)))]
    rivals = [t for t in scene.things.values() if t.id != thing.id and noun.labels <= t.labels]
    distinctions = _distinctions(scene, thing, rivals) if rivals and not vague else []
    if not distinctions:
        return _phrase(wording, noun, thing)
    return distinctions[int(rng.integers(len(distinctions)))].say(wording, noun, thing, rng)


def name_place(wording: Wording, place: Seen, rng: np.random.Generator) -> SDC:
    """Type the name of a place on the map, and return its OBJECT clause."""
    name = place.name
    lettered = name.split()[-1].isupper()  # "storage A"
    long = f"the {name}" if " " in name else f"the {name} area"
    return wording.leaf(name if lettered or rng.random() < 0.5 else long, place.id)


@dataclass(frozen=True, slots=True)
class _Distinction:
    """Property of one thing alone: an adjective, or a relation with perhaps a landmark."""

    adjective: str = ""
    relation: str = ""
    landmark: Seen | None = None

    def say(self, wording: Wording, noun: Noun, thing: Seen, rng: np.random.Generator) -> SDC:
        phrase = _phrase(wording, noun, thing, self.adjective)
        if not self.relation:
            return phrase
        relation = wording.say(self.relation)
        if self.landmark is None:
            return clause("OBJECT", relation, figure=phrase)
        nouns = NOUNS[self.landmark.kind]
        landmark = _phrase(wording, nouns[int(rng.integers(len(nouns)))], self.landmark)
        return clause("OBJECT", relation, landmark, figure=phrase)


def _phrase(wording: Wording, noun: Noun, thing: Seen, adjective: str = "") -> SDC:
    words = " ".join(filter(None, ("the", adjective, noun.head)))
    head = wording.leaf(words, thing.id)
    if not noun.of:
        return head
    relation = wording.say("of")
    return clause("OBJECT", relation, wording.leaf(noun.of, thing.id), figure=head)


def _distinctions(scene: Scene, thing: Seen, rivals: Sequence[Seen]) -> list[_Distinction]:
    return [
        *_likenesses(thing, rivals),
        *_sides(thing, rivals),
        *_ranges(thing, rivals),
        *_decks(scene, thing, rivals),
        *_neighbours(scene, thing, rivals),
    ]


def _likenesses(thing: Seen, rivals: Sequence[Seen]) -> list[_Distinction]:
    """Return distinctions by a look that it alone has: its colour, or its height."""
    adjectives: list[str] = [
        colour
        for colour in thing.colours[:1]
        if not any(colour in rival.colours for rival in rivals)
    ]
    heights = [rival.height for rival in rivals]
    if thing.height > CLEARLY_TALLER * max(heights):
        adjectives += ["tall", "tallest"]
    if CLEARLY_TALLER * thing.height < min(heights):
        adjectives += ["short", "shortest"]
    return [_Distinction(adjective) for adjective in adjectives]


def _sides(thing: Seen, rivals: Sequence[Seen]) -> list[_Distinction]:
    """Return distinctions from left to right as the robot sees it, if all are in front of it."""
    row = sorted((thing, *rivals), key=lambda t: -t.at[1])
    across = [t.at[1] for t in row]
    if min(t.at[0] for t in row) <= 0 or min(-np.diff(across)) < CLEARLY_M:
        return []
    place = row.index(thing)
    distinctions = []
    for side, rank in (("left", place), ("right", len(row) - 1 - place)):
        if rank == 0:
            distinctions += [
                _Distinction(adjective=f"{side}most"),
                _Distinction(relation=f"on the {side}"),
                _Distinction(adjective=side),
            ]
        if len(row) > 2 and rank < len(_ORDINALS):
            distinctions.append(_Distinction(_ORDINALS[rank], f"from the {side}"))
    return distinctions


def _ranges(thing: Seen, rivals: Sequence[Seen]) -> list[_Distinction]:
    """Return distinctions by distance from the robot."""
    distance_m = np.hypot(*thing.at)
    others = [np.hypot(*rival.at) for rival in rivals]
    if distance_m + CLEARLY_M < min(others):
        return [_Distinction(a) for a in ("nearest", "closest")]
    if distance_m > max(others) + CLEARLY_M:
        return [_Distinction("farthest")]
    return []


def _decks(scene: Scene, thing: Seen, rivals: Sequence[Seen]) -> list[_Distinction]:
    """Return distinctions by its support."""
    if not thing.deck or any(rival.deck for rival in rivals):
        return []
    return [_Distinction(relation="on", landmark=scene.things[thing.deck])]


def _neighbours(scene: Scene, thing: Seen, rivals: Sequence[Seen]) -> list[_Distinction]:
    """Return distinctions by a thing of another kind, unique in kind, that it alone is next to."""
    kinds = [t.kind for t in scene.things.values()]
    distinctions = []
    for other in scene.things.values():
        if other.deck or thing.deck or other.kind == thing.kind or kinds.count(other.kind) > 1:
            continue
        if other not in rivals and distance(thing, other) < BY_M:
            apart = min(distance(rival, other) for rival in rivals)
            if apart > distance(thing, other) + 2 * CLEARLY_M:
                distinctions += [
                    _Distinction(relation=r, landmark=other) for r in ("next to", "near")
                ]
    return distinctions
