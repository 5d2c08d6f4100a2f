"""Requests about several loads, carried out one load after the other.

"Put both crates on the truck" is one clause, and a forklift carries one crate at a time. So a
request is a run of top-level clauses that is gone through once for each of its loads: a clause that
picks things up, and those after it until they are put down. Which loads are meant is given by the
clause's OBJECT: its grammatical number, its quantifier and its exceptions, and the learned scores
of the loads that it may name. φ is true for each of them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import cycle, takewhile

import numpy as np

from g3.actions.robot_state import State, is_load
from g3.geometry.footprints import centre
from g3.groundings import PhysicalObject
from g3.inference.plan_things import ALIKE
from g3.inference.problem.asked_spots import scene_asked
from g3.inference.problem.clause_roles import is_source, stands_for_other
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import Frame, asked, frame, spares
from g3.inference.problem.grounding_problem import Candidate, GroundingProblem, Group, things_of
from g3.inference.problem.phrases import (
    is_complement,
    is_floor,
    is_pronoun,
    is_singled_out,
    names_other,
    names_robot,
    tells_standing,
)
from g3.inference.problem.world_nouns import LIKELY, Nouns
from g3.inference.search.thing_search import ground_thing, leaf_scores
from g3.language.discourse.groups import group, is_partitive, noun_leaf, noun_words
from g3.language.lexicon.concepts import BESIDE, concepts
from g3.language.lexicon.field_words import bare, bare_words, field_words, normalise
from g3.language.lexicon.tables import COUNTS, WORDS
from g3.language.similarity.presence import best_naming
from g3.language.similarity.word_similarity import labels_in
from g3.sdc.clauses import SDC
from g3.short_repr import short_repr

BEHIND = 2.5
"""Gap to the best log-probability at which a load is no member of a described group."""


@short_repr
@dataclass(frozen=True, slots=True)
class Request:
    """Top-level clauses that are carried out together, once for each load.

    Parameters
    ----------
    clauses
        The clauses, in their order.
    theme
        The OBJECT that names the loads; -1 in a request about one load, or none.
    loads
        For each load, in the order in which they are carried, the ids of the things that OBJECTs
        mean, by node: the load itself, and "each trailer" of "one crate on each trailer".
    """

    clauses: tuple[int, ...]
    theme: int = -1
    loads: tuple[Mapping[int, str], ...] = ()


def next_request(
    tree: Tree,
    left: Sequence[int],
    problem: GroundingProblem,
    state: State,
    meant: Mapping[int, tuple[Group, float]],
) -> Request:
    """Return the request that a command's next top-level clauses make.

    Parameters
    ----------
    tree
        The command.
    left
        The top-level clauses that are left, in their order.
    problem
        What they are grounded in.
    state
        The state that the plan so far leads to.
    meant
        Groundings of the clauses before, by node.
    """
    one = Request((left[0],))
    if tree.nodes[left[0]].type != "EVENT":
        return one
    own = frame(tree, left[0])
    if own.negated or own.forks or not own.handles:
        return one
    answer = problem.answers.get(own.objects[0], ()) if own.objects else ()
    several = answer if len(answer) > 1 else ()
    if not several and not _speaks_of_several(tree, own):
        return one
    clauses, theme = _run(tree, left, own), own.objects[0]
    named = several or _members(tree, own, problem, meant, _moved(problem.state, state))
    joined = _is_apart(tree, own, theme)
    members = _held_first(named, state, alone=not joined and _is_held_alone(tree, theme))
    if not clauses or members is None:
        return one
    targets = _targets(tree, own, problem)
    if targets is None:
        return Request(clauses, theme, tuple({theme: load} for load in members)) if members else one
    mark, things = targets
    if members:  # all that are named, in turn; otherwise one for each
        pairs = zip(members, cycle(things), strict=False)
    else:
        pairs = zip(
            (load.id for load, _ in loads_named(tree, theme, problem)), things, strict=False
        )
    return Request(clauses, theme, tuple({theme: load, mark: thing} for load, thing in pairs))


def _held_first(members: tuple[str, ...], state: State, *, alone: bool) -> tuple[str, ...] | None:
    """Return the loads of a request, what is on the forks first; None if it is in the way."""
    if state.held is None:
        return members
    if len(members) > 1 and state.held in members and not alone:
        return tuple(sorted(members, key=lambda load: load != state.held))
    return None


def _is_held_alone(tree: Tree, node: int) -> bool:
    """Check that a plural means the load on the forks alone: "put the tires down"."""
    sdc = tree.nodes[node]
    said = group(sdc)
    several = (said.count or 0) > 1 or said.quantifier
    counts = several or not WORDS["universal"].isdisjoint(noun_words(sdc))
    vague = WORDS["heaped"] | WORDS["generic"] | WORDS["everything"]
    alone = vague.intersection(field_words(noun_leaf(sdc).words)[-1:])
    return bool(alone or stands_for_other(sdc)) and not counts


def _speaks_of_several(tree: Tree, own: Frame) -> bool:
    """Check that a clause may be about several loads, before any is looked for."""
    marks = [n for place in (*own.places, *own.paths) for n in _marks(tree, place)]
    several = WORDS["universal"] | WORDS["rest"]
    return bool(own.objects) and (
        own.empties
        or sum(_is_apart(tree, own, n) for n in own.objects) > 1
        or any(group(tree.nodes[n]).number == "plural" for n in own.objects)
        or any(not several.isdisjoint(noun_words(tree.nodes[n])) for n in (*own.objects, *marks))
        or any(
            WORDS["everything"].intersection(field_words(_kind(tree, n).words)) for n in own.objects
        )
    )


def _run(tree: Tree, left: Sequence[int], own: Frame) -> tuple[int, ...]:
    """Return a clause with those after it that put its loads down; none if nothing does."""
    last = 0
    leads = own.places or own.paths or len(own.objects) > 1
    if own.verb and own.guessed and not leads:  # "blick the crates"
        return ()
    if not _puts(own):
        last = 1 + len(list(takewhile(lambda n: not _puts(frame(tree, n)), left[1:])))
        if last == len(left) or not all(_follows(tree, n) for n in left[1 : last + 1]):
            return ()  # the forks hold one load
    elif len(left) > 1 and _follows(tree, left[1]) and _agree(tree, own, frame(tree, left[1])):
        after = frame(tree, left[1])
        unloads = own.places_load and not (own.places or own.paths or own.end is not None)
        led = unloads and bool(after.places or after.paths)  # "empty it, all of it onto the truck"
        last = int(led or (not own.places_load and after.places_load))
    return tuple(left[: last + 1])


def _puts(own: Frame) -> bool:
    """Check that a clause leaves its load somewhere."""
    return own.places_load or bool(own.places or own.paths) or own.end is not None


def _follows(tree: Tree, root: int) -> bool:
    """Check that a clause continues with the loads of the clause before: "and put them down"."""
    if tree.nodes[root].type != "EVENT":
        return False
    own = frame(tree, root)
    if own.negated or (not own.handles and own.objects):
        return False
    return all(_names_again(tree.nodes[n]) for n in own.objects[:1])


def _agree(tree: Tree, own: Frame, after: Frame) -> bool:
    """Check that a clause with "it" doesn't follow one about all of some things."""
    again = [tree.nodes[n] for n in after.objects[:1] if is_pronoun(tree.nodes[n])]
    said = group(tree.nodes[own.objects[0]])
    several = said.quantifier in WORDS["universal"] or (said.count or 0) > 1
    return not several or all(group(sdc).number == "plural" for sdc in again)


def _names_again(sdc: SDC) -> bool:
    """Check that an OBJECT stands for loads spoken of before: "them", "both", "all of them"."""
    again = WORDS["universal"] | WORDS["it"] | {"of", "those", "these"}
    again |= {word for word, count in COUNTS["counts"].items() if count > 1}
    says_which = bool(sdc.relation) and not is_partitive(sdc)
    return is_pronoun(sdc) or (not says_which and again.issuperset(noun_words(sdc)))


def _moved(before: State, now: State) -> frozenset[str]:
    """Return the ids of the loads that a plan so far has moved."""
    pairs = zip(before.context.objects, now.context.objects, strict=True)
    return frozenset(a.id for a, b in pairs if a is not b and is_load(before, a.id))


def _members(
    tree: Tree,
    own: Frame,
    problem: GroundingProblem,
    meant: Mapping[int, tuple[Group, float]],
    moved: Collection[str],
) -> tuple[str, ...]:
    """Return the ids of the loads that a clause is about, if they are several."""
    coordinated = [n for n in own.objects if _is_apart(tree, own, n)]
    spoken = _antecedents(tree, own.objects[0], meant)
    if spoken is not None and len(coordinated) < 2:
        return spoken
    if own.empties and len(aboard := _aboard(tree, own.objects[0], problem)) > 1:
        return aboard
    there = at_source(tree, own, problem)
    found: list[str] = []
    for node in coordinated if len(coordinated) > 1 else own.objects[:1]:
        again = _antecedents(tree, node, meant)
        if again is None:
            loads = _named(tree, node, problem, meant, own.node, moved=moved, there=there)
        else:
            held = problem.state.held
            loads = [*again] or ([held] if held else [])
        if not loads and len(coordinated) > 1:
            best = [thing.id for thing, _ in _within(loads_named(tree, node, problem), there)]
            other = names_other(noun_leaf(tree.nodes[node]))
            loads = ([n for n in best if not other or n not in moved] or best)[:1]
        found += [name for name in loads if name not in found]
    return tuple(_but_there(tree, own, problem, found, meant))


def _aboard(tree: Tree, node: int, problem: GroundingProblem) -> tuple[str, ...]:
    """Return the ids of the loads on what an OBJECT names, if it names what carries loads."""
    best = [thing.id for c in ground_thing(tree, node, problem)[:1] for thing in things_of(c.group)]
    carries = {name for name in best if not is_load(problem.state, name)}
    loads = (load for load, below in problem.carriers.items() if below in carries)
    return tuple(load for load in loads if is_load(problem.state, load))


def _is_apart(tree: Tree, own: Frame, node: int) -> bool:
    """Check that an OBJECT is one of several coordinated ones in the same field."""
    fields = tree.children[own.node]
    return any(node in fields.get(name, ()) and len(fields[name]) > 1 for name in ("f", "l"))


def _antecedents(
    tree: Tree, node: int, meant: Mapping[int, tuple[Group, float]]
) -> tuple[str, ...] | None:
    """Return the loads that a pronoun for several stands for; None if it is none."""
    sdc = tree.nodes[node]
    words = set(noun_words(sdc))
    if not _names_again(sdc):
        return None
    before = [x.index for x in tree.antecedents.get(node, ()) if x.index in meant]
    if not before and words <= WORDS["universal"]:
        before = [n for n in reversed(list(meant)) if n < node and len(meant[n][0]) > 1]
    for n in before[:1]:
        ids = tuple(thing.id for thing in things_of(meant[n][0]))
        return ids if group(sdc).number == "plural" else ids[:1]
    return () if is_pronoun(sdc) else None


def _named(
    tree: Tree,
    node: int,
    problem: GroundingProblem,
    meant: Mapping[int, tuple[Group, float]],
    root: int,
    *,
    moved: Collection[str] = (),
    there: Collection[str] = (),
) -> list[str]:
    """Return the ids of the loads that an OBJECT of a clause names, if it speaks of several.

    What was moved before is named again by a pronoun, or together with all others. Of loads that
    are taken from somewhere only those `there` count.
    """
    node, but = _without_exceptions(tree, node, root)
    sdc = tree.nodes[node]
    said = group(sdc)
    words = {said.quantifier, *noun_words(sdc)}
    every = not WORDS["universal"].isdisjoint(words) or not WORDS["everything"].isdisjoint(
        field_words(noun_leaf(sdc).words)
    )
    others = not WORDS["rest"].isdisjoint(words)
    count = 2 if "both" in words else said.count
    on = _standing(tree, node, problem)
    nounless = WORDS["rest"] | WORDS["ones"] | WORDS["articles"] | set(COUNTS["counts"])
    any_kind = others and nounless.issuperset(noun_words(sdc))
    named = loads_named(tree, node, problem, any_kind=any_kind)
    loads = _within(_within(named, there), on)
    loads = [load for load in loads if load[0].id not in moved] or loads
    if not (every or others or but or (count or 0) > 1):
        if said.number != "plural" or count == 1 or said.ordinals or said.collective:
            return []
        if len(loads) < 2 or not _are_counted(tree, node, root, standing=bool(on)):
            return []
    found = [(thing.id, score) for thing, score in (_rest(loads, meant) if others else loads)]
    if others and said.number == "singular":
        found = found if len(found) == 1 else []
    elif count and count > 1:
        together = _together(tree, node, problem, count) if _tells_more(tree, node) else []
        chosen = [c for c in found if c[0] in together]
        found = chosen if len(chosen) == count else found[:count]
    elif found and _tells_more(tree, node) and not (on and not is_singled_out(sdc.figure[0])):
        found = [c for c in found if c[1] >= found[0][1] - BEHIND]
    return [name for name, _ in found]


def _together(tree: Tree, node: int, problem: GroundingProblem, count: int) -> list[str]:
    """Return the ids of the group that an OBJECT means: "the two crates on the left"."""
    groups = (things_of(c.group) for c in ground_thing(tree, node, problem))
    return next(([thing.id for thing in g] for g in groups if len(g) == count), [])


def _rest(
    loads: Sequence[tuple[PhysicalObject, float]], meant: Mapping[int, tuple[Group, float]]
) -> list[tuple[PhysicalObject, float]]:
    """Leave out what earlier clauses mean; keep its kinds, if there are more of them."""
    before = {thing.id: thing.labels for group, _ in meant.values() for thing in things_of(group)}
    left = [load for load in loads if load[0].id not in before]
    kinds = set(before.values())
    return [load for load in left if load[0].labels in kinds] or left


def _without_exceptions(tree: Tree, node: int, root: int) -> tuple[int, bool]:
    """Return the OBJECT without "all but the red one", and whether its clause excepts any."""
    excepting = [n for n in tree.all_below(root) if tree.excepts(n)]
    while node in excepting and (inner := tree.below(node, ("f",), "OBJECT")):
        node = inner[0]
    return node, bool(excepting)


def _kind(tree: Tree, node: int) -> SDC:
    """Return the leaf that names the kind of an OBJECT: "bricks" of "two loads of the bricks"."""
    sdc = tree.nodes[node]
    while sdc.figure:
        if is_complement(sdc) and sdc.landmark1:
            inner = noun_leaf(sdc.landmark1[0])
            if inner.words and bare(inner.words[-1].text) not in WORDS["pronouns"]:
                return inner
        sdc = sdc.figure[0]
    left_out = tree.left_out(sdc)
    return SDC("OBJECT", (*sdc.words[:-1], *left_out)) if left_out else sdc


def _called(things: Sequence[PhysicalObject], tree: Tree, node: int) -> list[PhysicalObject]:
    """Keep the things whose label is an OBJECT's noun, or else those that the noun is like."""
    noun = bare_words(_kind(tree, node).words)
    said = set(map(normalise, noun))
    found = [t for t in things if not said.isdisjoint(map(normalise, t.labels))]
    if found or not noun:
        return found
    likely = [best_naming(noun[-1], [thing.labels]) for thing in things]
    least = max([LIKELY, *(likeness - ALIKE for likeness in likely)])
    return [thing for thing, likeness in zip(things, likely, strict=True) if likeness >= least]


def _of_a_kind(things: Sequence[PhysicalObject], tree: Tree, node: int) -> list[PhysicalObject]:
    """Keep the things that an OBJECT's noun names: by labels, or those like the best one."""
    counting = WORDS["universal"] | WORDS["articles"] | set(COUNTS["counts"]) | {"any"}
    counting |= WORDS["rest"] | WORDS["ones"]
    kind = [word for word in noun_words(_kind(tree, node)) if word not in counting]
    while kind and normalise(kind[-1]) in WORDS["everything"] | WORDS["generic"]:  # "fridge lots"
        kind.pop()
    if not things or not kind:
        return list(things)
    fits = [(n := labels_in(kind, t.labels), n - len(t.labels)) for t in things]
    if not max(fits)[0]:
        return [thing for thing in things if thing.labels == things[0].labels]
    return [thing for thing, fit in zip(things, fits, strict=True) if fit == max(fits)]


def _are_counted(tree: Tree, node: int, root: int, *, standing: bool) -> bool:
    """Check that a plural counts loads: "crates" does.

    "The tires on the left" may be one pallet of them; "the tires" are all there are, and "the tires
    on the ground" all that are there.
    """
    noun = field_words(noun_leaf(tree.nodes[node]).words)[-1:]
    return standing or WORDS["heaped"].isdisjoint(noun) or not _says_which(tree, node, root)


def _says_which(tree: Tree, node: int, root: int) -> bool:
    """Check that a clause says more of its loads than their kind, and where they go."""
    sdc = tree.nodes[node]
    owned = any(word.text.endswith(("'s", "’s")) for word in noun_leaf(sdc).words)
    if is_singled_out(sdc) or owned or tree.nodes[root].type != "EVENT":
        return True
    own = frame(tree, root)
    ways = {*own.places, *own.paths, *own.ways}
    marks = (tree.nodes[n] for way in ways for n in tree.all_below(way))
    noun = noun_words(sdc)[-1:]
    others = any(noun_words(mark)[-1:] == noun for mark in marks if mark.type == "OBJECT")
    return len(ways) > 1 or others


def loads_named(
    tree: Tree, node: int, problem: GroundingProblem, *, any_kind: bool = False
) -> list[tuple[PhysicalObject, float]]:
    """Return the loads that an OBJECT may name with their scores, but for those ruled out.

    The best come first, or the nearest where words give no more than the kind.
    """
    wide = replace(problem, width=len(problem.scene.groups))
    singles = _singles(ground_thing(tree, node, wide), problem.state)
    things = [thing for thing, _ in singles]
    if not any_kind:
        things = _of_a_kind(things, tree, node)
        if not _called(things, tree, node):  # only like what is meant, so not what is ruled out
            allowed = [thing for thing, _ in singles if thing.id not in problem.ruled_out]
            things = _of_a_kind(allowed, tree, node)
    kept = {thing.id for thing in things} - problem.ruled_out
    singles = [c for c in singles if c[0].id in kept]
    if _tells_more(tree, node):
        return singles
    at = np.array(problem.state.pose[:2])
    return sorted(singles, key=lambda c: float(np.linalg.norm(centre(c[0].prism) - at)))


def loads_there(
    tree: Tree, node: int, problem: GroundingProblem
) -> list[tuple[PhysicalObject, float]]:
    """Return :func:`loads_named`, those alone that stand where the OBJECT says, if any does."""
    return _within(loads_named(tree, node, problem), _standing(tree, node, problem))


def _tells_more(tree: Tree, node: int) -> bool:
    """Check that an OBJECT says more of its things than how many, and of what kind."""
    sdc = tree.nodes[node]
    return is_singled_out(sdc) and not WORDS["rest"].intersection(noun_words(sdc))


def _singles(beam: Sequence[Candidate], state: State) -> list[tuple[PhysicalObject, float]]:
    found: dict[str, tuple[PhysicalObject, float]] = {}
    for c in beam:
        things = things_of(c.group)
        if len(c.group) == len(things) == 1 and is_load(state, things[0].id):
            found.setdefault(things[0].id, (things[0], c.score))
    return list(found.values())


def at_source(tree: Tree, own: Frame, problem: GroundingProblem) -> frozenset[str]:
    """Return the ids of the loads that stand where a clause takes something from."""
    marks = [n for way in own.ways if is_source(tree.nodes[way]) for n in _marks(tree, way)]
    return _loads_on(tree, marks[:1], problem)


def _standing(tree: Tree, node: int, problem: GroundingProblem) -> frozenset[str]:
    """Return the ids of the loads on what an OBJECT says they stand on: "all on the ground"."""
    sdc = tree.nodes[node]
    if not sdc.figure or not tells_standing(sdc):
        return frozenset()
    return _loads_on(tree, _marks(tree, node)[:1], problem)


def _loads_on(tree: Tree, marks: Sequence[int], problem: GroundingProblem) -> frozenset[str]:
    """Return the ids of the loads on what OBJECTs name: the ground, or the things that fit best."""
    loads = {o.id for o in problem.state.context.objects if is_load(problem.state, o.id)}
    if any(is_floor(tree.nodes[node]) for node in marks):
        return frozenset(loads - problem.carriers.keys())
    best: set[str] = set()
    for node in marks:
        named = [t for c in ground_thing(tree, node, problem)[:1] for t in things_of(c.group)]
        best |= {thing.id for thing in _called(named, tree, node)}
    return frozenset(load for load in loads if problem.carriers.get(load) in best)


def _within(
    loads: list[tuple[PhysicalObject, float]], there: Collection[str]
) -> list[tuple[PhysicalObject, float]]:
    """Keep the loads that stand there, if any does."""
    return [load for load in loads if load[0].id in there] or loads


def _but_there(
    tree: Tree,
    own: Frame,
    problem: GroundingProblem,
    loads: list[str],
    meant: Mapping[int, tuple[Group, float]],
) -> list[str]:
    """Leave out the loads that are on what they are to be put on, unless all are."""
    goals = [n for n in (*own.places, *own.paths) if _leads_onto(tree.nodes[n])]
    for node in [mark for goal in goals for mark in _marks(tree, goal)][:1]:
        spoken = [meant[x.index][0] for x in tree.antecedents.get(node, ()) if x.index in meant]
        groups = spoken or [c.group for c in ground_thing(tree, node, problem)]
        best = {thing.id for group in groups[:1] for thing in things_of(group)}
        loads = [n for n in loads if problem.carriers.get(n) not in best and n not in best] or loads
    return loads


def _leads_onto(sdc: SDC) -> bool:
    """Check that a PLACE or a PATH leads onto its landmark, or to it: not beside it."""
    said = concepts(field_words(sdc.relation))
    return not sdc.relation or (bool(said & {"on", "to"}) and not said & BESIDE)


def _marks(tree: Tree, node: int) -> list[int]:
    found = tree.below(node, ("l", "l2"), "OBJECT")
    return [n for n in found if not names_robot(tree.nodes[n])]


def _targets(
    tree: Tree, own: Frame, problem: GroundingProblem
) -> tuple[int, tuple[str, ...]] | None:
    """Return the landmark that takes one load each, and the things that it names."""
    for node in [n for place in (*own.places, *own.paths) for n in _marks(tree, place)]:
        words = noun_words(tree.nodes[node])
        if WORDS["distributive"].isdisjoint(words[:1]) or (
            words[-1:] and words[-1] in WORDS["others"]
        ):
            continue
        beam = ground_thing(tree, node, replace(problem, width=len(problem.scene.groups)))
        things = [t for c in beam if len(c.group) == 1 for t in things_of(c.group)]
        apart = [t for t in things if not is_load(problem.state, t.id)]
        found = dict.fromkeys(t.id for t in _called(apart, tree, node))
        if len(found) > 1:
            return node, tuple(found)
    return None


def ruled_out(tree: Tree, problem: GroundingProblem) -> frozenset[str]:
    """Return the ids of the loads that a command says must not be handled, anywhere in it.

    Not of what a pronoun stands for: "lift the crate, but don't drop it" forbids to drop it only.
    """
    nodes, others = tree.left_alone
    found: set[str] = set()
    for node in nodes:
        found |= _forbidden(tree, node, problem)
    for root in asked(tree):
        if tree.nodes[root].type != "EVENT":
            continue
        own = frame(tree, root)
        verb = {"left", *WORDS["leaving"]}.intersection(bare_words(tree.nodes[root].relation))
        forbids = own.negated and not (verb and own.places)  # "no crate is to be left there"
        if forbids or (spares(tree, root, None) and problem.state.held is None):
            for node in {*own.objects} - nodes - tree.put_elsewhere:
                found |= _forbidden(tree, node, problem)
    for sdc in others:
        noun = _naming_load(sdc, tree, Nouns(problem.state))
        if noun is not None:
            alone = Tree((noun,))
            leaves = leaf_scores(alone, problem.scene, problem.cost)
            found |= _forbidden(alone, 0, replace(problem, leaves=leaves))
    return frozenset(found)


def _naming_load(sdc: SDC, tree: Tree, nouns: Nouns) -> SDC | None:
    """Return a leaf up to the last word that names a load; None if none does.

    "The left ones" are of the kind that is named before.
    """
    last = [i for i, word in enumerate(sdc.words) if nouns.name_load((word,))]
    if last:
        return replace(sdc, words=sdc.words[: last[-1] + 1])
    ones = [i for i, word in enumerate(sdc.words) if bare(word.text) in WORDS["ones"]]
    before = [n.words[-1] for n in tree.nodes if n.type == "OBJECT" and n.words]
    kinds = [w for w in before if w.end <= sdc.words[0].start and nouns.name_load((w,))]
    if not ones or not kinds:
        return None
    return replace(sdc, words=(*sdc.words[: ones[-1]], max(kinds, key=lambda w: w.start)))


def _forbidden(tree: Tree, node: int, problem: GroundingProblem) -> set[str]:
    """Return the ids of the loads that an OBJECT rules out."""
    words = noun_words(tree.nodes[node])
    names_none = WORDS["nothing"].issuperset(words) or not {"else", *WORDS["rest"]}.isdisjoint(
        words
    )
    if is_pronoun(tree.nodes[node]) or names_none:
        return set()
    if not WORDS["anything"].isdisjoint(words):
        return {thing.id for thing, _ in loads_named(tree, node, problem)}
    return set(_named(tree, node, problem, {}, node) or _best(tree, node, problem))


def _best(tree: Tree, node: int, problem: GroundingProblem) -> list[str]:
    """Return the loads that an OBJECT for one thing means: all that its kind may name, if alone."""
    words = noun_words(tree.nodes[node])
    if not words:
        return []
    singles = [thing for thing, _ in _singles(ground_thing(tree, node, problem), problem.state)]
    if words[-1] not in WORDS["nounless"]:
        singles = _called(singles, tree, node)
    alone = not _tells_more(tree, node) and words[-1] not in WORDS["nounless"]
    return [thing.id for thing in (singles if alone else singles[:1])]


def after(tree: Tree, problem: GroundingProblem, state: State) -> GroundingProblem:
    """Return the problem for the next load: things are where they are now, seen as at first."""
    first, now = problem.state.context, state.context
    objects = tuple(first.agent if o.id == now.agent_id else o for o in now.objects)
    seen = replace(state, context=replace(now, objects=objects))
    again = replace(problem, state=seen, scene=scene_asked(tree, seen))
    return replace(again, leaves=leaf_scores(tree, again.scene, again.cost))
