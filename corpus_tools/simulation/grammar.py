"""A grammar of simulated workers' commands for the robot's actions.

The robot's script is cut into what it gets and what it does with it. Each has several plans: one
clause for both ("Put the tires on the truck"), or a clause for each ("Go to the tires, pick them
up, and put them on the truck"), with verbs whose particle may stand apart. The phrases for things
are :mod:`corpus_tools.simulation.referring`'s.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from corpus_tools.simulation.referring import name_place, refer
from corpus_tools.simulation.seen_scenes import Scene, Seen, distance
from corpus_tools.simulation.wording import POLITE, Wording, Worker, clause, misspell
from corpus_tools.world.state.robot_script import DRIVE_TO
from g3.actions.forklift_actions import DRIVE_PAST, PICK_UP, PUT_DOWN
from g3.errors import CorpusError
from g3.sdc.clauses import SDC
from g3.short_repr import short_repr

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
