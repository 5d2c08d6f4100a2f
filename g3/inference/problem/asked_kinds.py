"""Kinds of actions that clauses ask for, by their verbs and the words before their landmarks.

Corpora have few clauses of these kinds, and logs show them in the middle of others. So their
words are read by hand, and only where they say one thing.
"""

from __future__ import annotations

from collections.abc import Callable

from g3.actions.action_kinds import ActionKind, Amounts
from g3.actions.forklift_actions import (
    BACK_UP,
    CARRY,
    DRIVE_AROUND,
    DRIVE_AWAY,
    DRIVE_PAST,
    DRIVE_TO,
    FACE,
    GO_STRAIGHT,
    LINE_UP,
    LOWER_FORKS,
    PARK,
    PICK_UP,
    PUT_DOWN,
    RAISE_FORKS,
    TURN,
    TURN_AWAY,
    WAIT,
)
from g3.inference.problem.clause_roles import (
    goal_paths,
    goal_places,
    goal_within,
    is_company,
    is_source,
    names_own_forks,
    objects,
    subjects,
    told_ways,
)
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import Frame, asked, frame
from g3.inference.problem.phrases import is_measure, names_forks, names_lift, names_robot
from g3.language.discourse.negation import negated
from g3.language.lexicon.concepts import SIDES, concepts
from g3.language.lexicon.field_words import bare, bare_words, field_words, figure_words
from g3.language.lexicon.measures import metres_said, radians_said, seconds_said
from g3.language.lexicon.tables import WORDS
from g3.language.lexicon.verb_classes import VERBS, word_class
from g3.sdc.clauses import SDC, Field, SDCType, all_words

Kinds = frozenset[ActionKind]
WAYS: Kinds = frozenset({DRIVE_AROUND, DRIVE_AWAY, DRIVE_PAST, LINE_UP, TURN_AWAY})
"""Kinds of which the way is asked for, and not its end."""
_ARGUMENTS: tuple[Field, ...] = ("l", "l2")


def asked_kinds(tree: Tree, root: int) -> Kinds:
    """The kinds of actions that a top-level clause asks for; none where it leaves that open."""
    if negated(tree.nodes[root]):
        stays = _stays_put(tree, root) or _only_forbids(tree)
        return frozenset({WAIT}) if stays else frozenset()
    readings = (kinds for reads in _READINGS if (kinds := reads(tree, root)))
    return next(readings, frozenset())


def asks_to_wait(tree: Tree) -> bool:
    """Check that a command asks for nothing but waiting."""
    wanted = [n for n in asked(tree) if asked_kinds(tree, n) or not negated(tree.nodes[n])]
    return bool(wanted) and all(asked_kinds(tree, root) == {WAIT} for root in wanted)


def asks_for_way(tree: Tree) -> bool:
    """Check that a command asks for a way, or for so many metres or degrees of one."""
    amounts = (amounts_said(tree, root) for root in asked(tree))
    if any(own.metres is not None or own.radians is not None for own in amounts):
        return True
    return any(asked_kinds(tree, root) & WAYS for root in asked(tree))


def _only_forbids(tree: Tree) -> bool:
    """Check that a command asks for nothing but leaving things: "don't start yet"."""
    return all(frame(tree, n).negated for n in asked(tree))


def _stays_put(tree: Tree, root: int) -> bool:
    """Check that a negated clause is about nothing but the robot's moving: "don't move"."""
    said, places = _said(tree.nodes[root]), _said_of_places(tree, root, "PATH", "PLACE", "OBJECT")
    moves = tree.verbs[root].classes & {"going"} or said & WORDS["moving"]
    return bool(moves) and all(words <= WORDS["start"] | WORDS["anywhere"] for words in places)


def _said(sdc: SDC) -> set[str]:
    return set(bare_words(sdc.relation))


def _verbs(tree: Tree, root: int) -> set[str]:
    """The classes of all verbs of a clause."""
    of_words = (word_class(word).split("+") for word in _said(tree.nodes[root]))
    return {name for names in of_words for name in names} & VERBS


def _is_robot(sdc: SDC) -> bool:
    """Check that an OBJECT is the robot or a part of it: "the forklift", "your forks"."""
    return names_robot(sdc) or names_forks(sdc) or names_lift(sdc)


def _things(tree: Tree, root: int) -> list[int]:
    """OBJECTs of a clause but for the robot itself."""
    if tree.nodes[root].type == "PATH":
        return []
    return [n for n in objects(tree, root) if not _is_robot(tree.nodes[n])]


def _ways(tree: Tree, root: int) -> list[int]:
    """PATHs and PLACEs of a clause that have a landmark.

    What is said of the robot itself is its way: "move [the forklift away from the truck]".
    """
    if tree.nodes[root].type == "PATH":
        return [root]
    told = tree.below(root, _ARGUMENTS, "PATH", "PLACE")
    told += [n for n in tree.below(root, _ARGUMENTS, "OBJECT") if _is_robot(tree.nodes[n])]
    return [n for n in told if tree.nodes[n].relation and tree.nodes[n].landmark1]


def _leads(tree: Tree, root: int) -> bool:
    paths = [p for p in goal_paths(tree, root) if tree.nodes[p].landmark1]
    return bool(paths or goal_places(tree, root)) or goal_within(tree, root) is not None


def returns(tree: Tree, root: int) -> bool:
    """Check that a clause sends the robot back to where it was told: "come back here", "back here".

    "Go back", with nothing before it, is said of the way.
    """
    if tree.nodes[root].type != "EVENT" or amounts_said(tree, root).metres is not None:
        return False
    said = _said(tree.nodes[root])
    places = _said_of_places(tree, root, "PATH", "PLACE", "OBJECT", "EVENT")
    places = [words for words in places if words.isdisjoint(WORDS["when"])]
    verb = said <= WORDS["returning"] | WORDS["start"]
    verb = verb and (not said or bool(said & WORDS["returning"]))
    open_verb = tree.verbs[root].is_open or _verbs(tree, root) == {"going"}
    verb = verb or (open_verb and "back" in said)  # "hustle back"
    verb = verb or _verbs(tree, root) == {"staying"}  # "stop where you started"
    back = any(words & WORDS["back"] for words in (said, *places))
    named = [words for words in places if words != {"back"}]
    there = all(words <= WORDS["start"] for words in named) and bool(
        named or root != asked(tree)[0]
    )
    spots = all(
        WORDS["areas"].intersection(figure_words(tree.nodes[n])) for n in _things(tree, root)
    )
    return verb and back and there and spots


def puts_here(tree: Tree, own: Frame) -> bool:
    """Check that a clause puts a load down where the robot is: "here", "on the spot"."""
    places = _said_of_places(tree, own.node, "PATH", "PLACE")
    said = {word for words in places for word in words}
    here = not said.isdisjoint(WORDS["here"]) and said.isdisjoint(WORDS["elsewhere"])
    return own.places_load and here and said <= WORDS["start"] | WORDS["floor"]


def _said_of_places(tree: Tree, root: int, *types: SDCType) -> list[set[str]]:
    """Return the words of a clause's arguments of some types, of each by itself."""
    told = tree.below(root, _ARGUMENTS, *types)
    told = [n for n in told if not (is_measure(tree.nodes[n]) or is_company(tree.nodes[n]))]
    return [set(bare_words(all_words(tree.nodes[n]))) for n in told]


def _returning(tree: Tree, root: int) -> Kinds:
    """Come back; return to where you were."""
    return frozenset({DRIVE_TO}) if returns(tree, root) else frozenset()


def _staying(tree: Tree, root: int) -> Kinds:
    """Stay where you are; wait there; keep hold of it; don't move."""
    said = _said(tree.nodes[root])
    if said <= WORDS["holding"] and len(said) > 1 and not said.isdisjoint(("hang", "keep", "hold")):
        return frozenset({WAIT})
    stays = "staying" in _verbs(tree, root)
    here = all(words <= WORDS["start"] for words in _said_of_places(tree, root, "PATH", "PLACE"))
    named = (set(bare_words(all_words(tree.nodes[n]))) for n in _things(tree, root))
    alone = "with" in said or all(words <= WORDS["start"] for words in named)
    return frozenset({WAIT}) if stays and here and alone else frozenset()


def _around(tree: Tree, root: int) -> Kinds:
    """Go around the truck; do a lap of it."""
    paths = [n for n in _ways(tree, root) if _said(tree.nodes[n]) & WORDS["orbiting"]]
    alone = bool(paths) and paths == _ways(tree, root) and not _verbs(tree, root) & {"placing"}
    laps = all(WORDS["laps"].intersection(figure_words(tree.nodes[n])) for n in objects(tree, root))
    return frozenset({DRIVE_AROUND}) if alone and laps else frozenset()


def _lining_up(tree: Tree, root: int) -> Kinds:
    """Line up with the pallet; align the forks with it."""
    said, things = _said(tree.nodes[root]), _things(tree, root)
    lines = bool(said & WORDS["aligning"]) or (bool(said & WORDS["lining"]) and "up" in said)
    with_it = any("with" in _said(tree.nodes[n]) for n in _ways(tree, root))
    asks = lines and (with_it or "with" in said) and len(things) <= ("with" in said)
    return frozenset({LINE_UP}) if asks else frozenset()


def _forks(tree: Tree, root: int) -> Kinds:
    """Raise or lower the forks; to lower them with a load may be to put it down."""
    if not names_own_forks(tree, root) or _things(tree, root):
        return frozenset()
    said = _said(tree.nodes[root])
    if said & WORDS["raising"] and not said & WORDS["lowering"]:
        return frozenset({RAISE_FORKS})
    if said & WORDS["lowering"] and not said & WORDS["raising"]:
        return frozenset({LOWER_FORKS, PUT_DOWN})
    return frozenset()


def _away(tree: Tree, root: int) -> Kinds:
    """Drive, back or turn away from the truck."""
    leaves = [n for n in _ways(tree, root) if _is_away(tree, root, n)]
    verbs, root_is_path = _verbs(tree, root), tree.nodes[root].type == "PATH"
    if not leaves or _things(tree, root) or verbs & {"staying", "placing"}:
        return frozenset()
    if not root_is_path and _leads(tree, root):
        return frozenset()
    if "back" in concepts(field_words(tree.nodes[root].relation)):
        return frozenset({BACK_UP})
    return frozenset({TURN_AWAY if verbs == {"turning"} else DRIVE_AWAY})


def _is_away(tree: Tree, root: int, way: int) -> bool:
    said = _said(tree.nodes[way]) | _said(tree.nodes[root])
    return {"from", "away"} <= said


def _past(tree: Tree, root: int) -> Kinds:
    """Drive past the pallet; pass it; a load that is carried past it may be lifted before."""
    if tree.nodes[root].type == "PATH":
        asks = bool(_said(tree.nodes[root]) & WORDS["passing"])
        return frozenset({DRIVE_PAST}) if asks else frozenset()
    if _verbs(tree, root) & {"placing", "taking"} or goal_places(tree, root):
        return frozenset()
    things, paths = _things(tree, root), _ways(tree, root)
    if _said(tree.nodes[root]) & WORDS["passing"]:
        return frozenset({DRIVE_PAST}) if things and not paths else frozenset()
    past = [n for n in paths if _said(tree.nodes[n]) & WORDS["passing"]]
    only = bool(past) and past == paths and goal_within(tree, root) is None
    if only and things:
        return frozenset({DRIVE_PAST, PICK_UP, CARRY, PUT_DOWN})
    return frozenset({DRIVE_PAST}) if only else frozenset()


def _coming(tree: Tree, root: int) -> Kinds:
    """Approach the man; reach the truck."""
    comes = _said(tree.nodes[root]) & WORDS["approaching"] and _verbs(tree, root) == {"going"}
    return frozenset({DRIVE_TO}) if comes and _things(tree, root) else frozenset()


def _facing(tree: Tree, root: int) -> Kinds:
    """Face the truck; turn towards it."""
    things, said = _things(tree, root), _said(tree.nodes[root])
    ways = _ways(tree, root)
    if said & WORDS["facing"] and (things or ways):
        return frozenset({FACE})
    if _verbs(tree, root) != {"turning"} or things:
        return frozenset()
    toward = [n for n in ways if _is_toward(tree, n)]
    return frozenset({FACE}) if toward and toward == ways else frozenset()


def _is_toward(tree: Tree, way: int) -> bool:
    """Check that a PATH leads towards a thing, not to a side: "to your left"."""
    if "to" not in concepts(field_words(tree.nodes[way].relation)):
        return False
    marks = tree.below(way, _ARGUMENTS, "OBJECT", "PLACE")
    named = [concepts(figure_words(tree.nodes[n])) for n in marks]
    return bool(named) and not any(own & SIDES for own in named)


def _measured(tree: Tree, root: int) -> Kinds:
    """Turn by 90 degrees; go ten metres; back up two feet; but "two feet to the left" is a spot."""
    amounts = amounts_said(tree, root)
    if amounts.radians is not None:
        return frozenset({TURN})
    told = told_ways(tree, root)
    if amounts.metres is None or told & {"left", "right"}:
        return frozenset()
    return frozenset({BACK_UP if "back" in told else GO_STRAIGHT})


def _parking(tree: Tree, root: int) -> Kinds:
    """Park by the truck, or in a place; but "park it there" puts something down."""
    asks = _said(tree.nodes[root]) & WORDS["parking"] and _leads(tree, root)
    return frozenset({PARK}) if asks and not _things(tree, root) else frozenset()


def _ends_there(tree: Tree, root: int) -> bool:
    """Check that a clause ends where earlier ones lead: "stop when you get there"."""
    end = goal_within(tree, root)
    words = set(bare_words(all_words(tree.nodes[end]))) if end is not None else set()
    return bool(words) and words <= WORDS["it"] | {"there", "here"}


def _waiting(tree: Tree, root: int) -> Kinds:
    """Wait; hold for ten seconds; keep it on the forks; but "stop at the truck" goes there."""
    below = (tree.nodes[n] for n in tree.all_below(root))
    keeps = _said(tree.nodes[root]) & WORDS["keeping"] and any(map(names_forks, below))
    if keeps or amounts_said(tree, root).seconds is not None:
        return frozenset({WAIT})
    verbs = _verbs(tree, root)
    leads = _leads(tree, root) and not _ends_there(tree, root)
    if verbs != {"staying"} or leads or _ways(tree, root):
        return frozenset()
    still = "keep" not in _said(tree.nodes[root]) and not subjects(tree, root)
    return frozenset({WAIT}) if still else frozenset()


_READINGS: tuple[Callable[[Tree, int], Kinds], ...] = (
    _returning,
    _staying,
    _around,
    _lining_up,
    _forks,
    _away,
    _past,
    _coming,
    _facing,
    _measured,
    _parking,
    _waiting,
)
"""What a clause may ask for. The first that it does counts."""


def amounts_said(tree: Tree, root: int) -> Amounts:
    """The amounts of a clause that only goes, turns or moves the forks.

    It names no thing but one that it leaves: "back up three metres from the truck".
    """
    return tree.once(_amounts_said, root)


def _amounts_said(tree: Tree, root: int) -> Amounts:
    if tree.nodes[root].type != "EVENT":
        return Amounts()
    said = [bare(word.text) for word in sorted(all_words(tree.nodes[root]), key=lambda w: w.start)]
    classes = frame(tree, root).classes
    if "staying" in classes and not frame(tree, root).objects:
        return Amounts(seconds=seconds_said(said))
    parts = tree.below(root, ("l", "l2"), "OBJECT", "PLACE", "PATH", "EVENT")
    parts = [part for part in parts if not is_source(tree.nodes[part])]
    below = [tree.nodes[n] for part in parts for n in tree.all_below(part)]
    named = [sdc for sdc in below if sdc.type == "OBJECT" and sdc.words]
    own = (is_measure, names_robot, names_forks, names_lift)
    if not all(any(f(sdc) for f in own) for sdc in named):
        return Amounts()
    if names_own_forks(tree, root):
        return Amounts(metres=metres_said(said))
    if not classes or classes - {"going", "turning"}:
        return Amounts()
    return Amounts(metres_said(said), radians_said(said) if "turning" in classes else None)
