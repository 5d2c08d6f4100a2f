"""The frame of a clause that asks for something: what is to be done, and its arguments.

A frame is read from a clause's tree, once (:func:`frame`). Its verb is the one that says what to
do, wherever that stands: "get ready to lift the crate" and "use the forks to lift the crate" have
the frame of "lift the crate". A verb that isn't known asks for what its arguments allow.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from g3.inference.problem.clause_roles import (
    goal_paths,
    goal_places,
    goal_within,
    is_company,
    is_goal,
    is_source,
    names_own_forks,
    objects,
    subjects,
    told_ways,
    ways,
)
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.phrases import (
    is_floor,
    is_measure,
    is_nounless,
    is_pronoun,
    is_there,
    names_forks,
    names_held,
    names_robot,
    side_by_side,
)
from g3.language.discourse.groups import group, noun_leaf, noun_words
from g3.language.discourse.negation import negated
from g3.language.lexicon.field_words import bare_words, field_words, figure_words, normalise
from g3.language.lexicon.tables import WORDS
from g3.language.lexicon.verb_classes import HANDLING_VERBS, word_class
from g3.sdc.clauses import SDC, Field, all_words
from g3.short_repr import short_repr

_ARGUMENTS: tuple[Field, ...] = ("l", "l2")
_JOINED = len(" and ")
"""A clause that begins no further behind another one is joined to it by "and" at most."""


@short_repr
@dataclass(frozen=True, slots=True)
class Frame:
    """Request of a clause: its verb, arguments and directions.

    Parameters
    ----------
    node
        The clause that has the verb and its arguments.
    verb
        The verb that says what to do, with what stands behind it: "pick", "up".
    classes
        What the verb asks for: :data:`g3.language.lexicon.verb_classes.VERBS`. Of an unknown verb
        what its arguments allow; none where nothing is asked for.
    guessed
        Whether the verb isn't known, so that the classes follow from its arguments.
    negated
        Whether it says what must not be done.
    subjects
        What is said to do something or to be somewhere, if not the robot.
    objects
        What is handled, first, and what else is come to; nodes of OBJECTs.
    places, paths, end
        Where it leads: PLACEs; PATHs, those with "to" first; what another clause says is reached.
    ways
        PATHs, and PLACEs from which something is taken.
    until
        The clause that says when it ends, if there is one.
    instruments
        What it is done with.
    extents
        How far: "three metres".
    directions
        Ways that it names without a landmark: "back", "left".
    forks
        Whether the robot's forks are what is handled.
    down
        Whether something is put on the ground, and nothing else says where.
    frees
        Whether the forks are needed for another load next, so that what is taken is put down.
    """

    node: int
    verb: tuple[str, ...]
    classes: frozenset[str]
    guessed: bool
    negated: bool
    subjects: tuple[int, ...]
    objects: tuple[int, ...]
    places: tuple[int, ...]
    paths: tuple[int, ...]
    end: int | None
    ways: tuple[int, ...]
    until: int | None
    instruments: tuple[int, ...]
    extents: tuple[int, ...]
    directions: frozenset[str]
    forks: bool
    down: bool
    frees: bool

    @property
    def text(self) -> str:
        """The verb as it is said."""
        return " ".join(self.verb)

    @property
    def theme(self) -> int | None:
        """The OBJECT that is handled, or come to."""
        return self.objects[0] if self.objects else None

    @property
    def handles(self) -> bool:
        """Check that it asks for something to be done to a load."""
        return bool(self.classes & HANDLING_VERBS)

    @property
    def sends(self) -> bool:
        """Check that it says where something is in the end: "deliver it to the truck"."""
        return not WORDS["sending"].isdisjoint(map(normalise, self.verb[:1]))

    @property
    def empties(self) -> bool:
        """Check that it may name what something is taken off: "unload the truck"."""
        return not WORDS["emptying"].isdisjoint(self.verb[:1])

    @property
    def places_load(self) -> bool:
        """Check that it may ask for something to be put down."""
        return "placing" in self.classes

    @property
    def takes_unnamed(self) -> bool:
        """Check that it picks up something without a name: "drive to the crate and pick up"."""
        takes = not self.guessed and "taking" in self.classes
        return takes and not (
            self.objects or self.forks or self.classes & {"going", "placing", "staying"}
        )

    @property
    def leaves_open(self) -> bool:
        """Check that it puts something down without saying where: where the robot was sent."""
        return self.places_load and not (self.places or self.ways)


def frame(tree: Tree, node: int) -> Frame:
    """The frame of a clause that asks for something, one of those of :func:`asked`."""
    return tree.once(_frame, node)


def asked(tree: Tree) -> tuple[int, ...]:
    """The clauses of a command that ask for something or name something, in their order.

    They are the top-level clauses, but for those that only lead on. Of "I want you to lift the
    crate" it is the clause inside, and of "go and lift the crate" the second one. What is done
    for a purpose comes after what leads to it: "drive to the crate to lift it".
    """
    return tuple(tree.once(_leads))


def in_order(tree: Tree, *, holds: bool) -> tuple[int, ...]:
    """The clauses of :func:`asked` in the order of doing.

    Where the robot holds something, it first does what is asked of that: "the drum on the truck,
    and what you have by the gate".
    """
    order = asked(tree)
    if not holds:
        return order
    events = [frame(tree, n) for n in order if tree.nodes[n].type == "EVENT"]
    handling = [own for own in events if own.handles and not own.negated]
    held = [own.node for own in handling if any(names_held(tree.nodes[n]) for n in own.objects)]
    return tuple(sorted(order, key=lambda n: n not in held[:1])) if held else order


def _leads(tree: Tree) -> dict[int, tuple[int, ...]]:
    """The clauses that ask for something, each with those that lead on to it."""
    found: dict[int, tuple[int, ...]] = {}
    for root in range(len(tree.sdcs)):
        if not _passes_on(tree, root):
            found.update(_inside(tree, root, ()))
    return found


def _inside(tree: Tree, node: int, outer: tuple[int, ...]) -> Iterator[tuple[int, tuple[int, ...]]]:
    """The clause, or the clauses inside that it leads on to."""
    inner = _purposes(tree, node)
    verb = tree.verbs[node]
    alone = not verb.classes and (verb.leads_on or not verb.is_open)
    only_leads = alone or names_own_forks(tree, node) or not _has_arguments(tree, node)
    if not (inner and only_leads):
        yield node, outer
    if only_leads or any(tree.verbs[n].classes & HANDLING_VERBS for n in inner):
        for n in inner:
            yield from _inside(tree, n, (*outer, node))


def _purposes(tree: Tree, node: int) -> list[int]:
    """EVENTs inside a clause that say what it is for: "use the forks to lift it"."""
    verb = tree.verbs[node]
    connects = tree.nodes[node].type == "EVENT" and not verb.classes and not verb.is_open
    found = []
    for n in tree.below(node, _ARGUMENTS, "EVENT"):
        words = bare_words(tree.nodes[n].relation)
        begins = not WORDS["purposes"].isdisjoint((*words[:1], *_relation(tree, node)[-1:]))
        ends = not WORDS["until"].isdisjoint(words) or not WORDS["until"].isdisjoint(
            _relation(tree, node)
        )
        if (begins or connects or verb.leads_on) and not ends:
            found.append(n)
    return found


def _relation(tree: Tree, node: int) -> list[str]:
    return bare_words(tree.nodes[node].relation)


def _has_arguments(tree: Tree, node: int) -> bool:
    named = tree.below(node, _ARGUMENTS, "OBJECT", "PLACE", "PATH")
    return bool(named) or bool(told_ways(tree, node))


def _passes_on(tree: Tree, root: int) -> bool:
    """Check that a top-level clause only leads on to the next one: "go and", "let's".

    Trees don't have the words between clauses, so that the room between them tells.
    """
    after = root + 1
    if after >= len(tree.sdcs) or tree.nodes[root].type != "EVENT":
        return False
    if tree.nodes[after].type != "EVENT" or _purposes(tree, root):
        return False
    words = _relation(tree, root)
    bare_turn = tree.verbs[root].classes <= {"turning", "going"} and _is_purpose(tree, after)
    if not (tree.verbs[root].leads_on or bare_turn):
        return False
    if not side_by_side(tree.nodes[root], tree.nodes[after], _JOINED):
        return False
    named = tree.below(root, _ARGUMENTS, "OBJECT", "PLACE", "PATH")
    if not all(_is_robot(tree, n) or names_forks(tree.nodes[n]) for n in named):
        return False
    return words[-2:] == ["go", "ahead"] or not told_ways(tree, root)


def _is_purpose(tree: Tree, node: int) -> bool:
    return _relation(tree, node)[:1] in ([word] for word in WORDS["purposes"])


def _is_robot(tree: Tree, node: int) -> bool:
    return names_robot(tree.nodes[node]) or bool(
        set(bare_words(tree.nodes[node].words)) & {"s", "us", "robot"}
    )


def _frame(tree: Tree, node: int) -> Frame:
    verb = tree.verbs[node]
    outer = tree.once(_leads).get(node, ())
    named = tuple(objects(tree, node))
    alone, _ = tree.left_alone
    spared = bool(named) and alone.issuperset(named)
    named = named if spared else tuple(n for n in named if n not in alone)
    if verb.start:
        named = tuple(n for n in named if not _is_robot(tree, n))  # "help me lift it"
    tools = [n for n in tree.below(node, _ARGUMENTS, "PATH") if is_company(tree.nodes[n])]
    used = [n for own in tools for n in tree.below(own, _ARGUMENTS, "OBJECT")]
    used = [n for n in used if names_forks(tree.nodes[n])]
    used += [n for own in outer for n in tree.below(own, _ARGUMENTS, "OBJECT")]
    measures = tree.below(node, _ARGUMENTS, "OBJECT")
    places, paths = tuple(goal_places(tree, node)), tuple(goal_paths(tree, node))
    if verb.classes == {"turning"}:
        places = tuple(n for n in places if tree.nodes[n].landmark1)  # not "turn to the right"
    end = goal_within(tree, node)
    leads = bool(places or paths) or end is not None
    stays = "staying" in verb.classes and "placing" not in verb.classes  # not "must stand there"
    remains = stays and bool(subjects(tree, node))
    classes, comes_off = verb.classes, False
    if subjects(tree, node):
        comes_off = not leads and any(is_source(tree.nodes[n]) for n in ways(tree, node))
        classes = frozenset(("taking", "placing") if comes_off else ("carrying",))
    said = set(_relation(tree, node))
    if named and ((said & WORDS["emptying"] and not classes) or _clears(tree, node, classes)):
        classes = frozenset(("taking", "placing"))
    elif (
        said & WORDS["filling"]
        and not leads
        and _is_spoken_of(tree, named)
        and _has_led(tree, node)
    ):
        classes = frozenset(("placing",))
    aboard = (m for n in places for m in tree.nodes[n].landmark1)
    if said & WORDS["keeping"] and named and places and not any(map(names_forks, aboard)):
        classes = frozenset(("placing",))
    goals = (tree.nodes[n] for n in (*places, *paths))
    puts = any("placing" in word_class(word).split("+") for word in said)
    told = told_ways(tree, node)
    aims = bool(told & {"front", "back"}) or not any(sdc.landmark1 for sdc in goals)
    if not (named or puts) and (
        (said & WORDS["moving"] and aims)
        or ((leads or ways(tree, node)) and said <= WORDS["coming"])
    ):
        classes = frozenset(("going",))
    extents = tuple(n for n in measures if is_measure(tree.nodes[n]))
    if extents and told and not (classes or named):
        classes = frozenset(("going",))  # "forward 20 feet"
    leads = leads or len(named) > 1
    wordless = tree.nodes[node].type == "EVENT" and not said
    guessed = not classes and (verb.is_open or wordless or (verb.leads_on and named and leads))
    if guessed:
        classes = _guessed(theme=bool(named), leads=leads)
        guessed = not (wordless and named and leads)  # "the crate to the gate"
    return Frame(
        node,
        tuple(_relation(tree, node)[verb.start :]),
        classes,
        bool(guessed),
        remains or spared or any(negated(tree.nodes[n]) for n in (*outer, node)),
        tuple(subjects(tree, node)),
        named,
        places,
        paths,
        end,
        tuple(ways(tree, node)),
        next((n for n in tree.below(node, _ARGUMENTS, "EVENT") if _is_end(tree, n)), None),
        tuple(n for n in used if not names_robot(tree.nodes[n])),
        extents,
        told,
        names_own_forks(tree, node),
        classes == {"placing"} and bool(places) and all(_is_down(tree.nodes[n]) for n in places),
        comes_off or (classes == {"taking", "placing"} and _are_needed(tree, node)),
    )


def _clears(tree: Tree, node: int, classes: frozenset[str]) -> bool:
    """Check that a clause takes off what no later one puts down.

    That is several things, which the forks can't hold at once, or one where the next clause needs
    the forks for another.
    """
    if classes != {"taking"} or not any(is_source(tree.nodes[n]) for n in ways(tree, node)):
        return False
    taken = tree.nodes[objects(tree, node)[0]]
    theme = group(taken)
    several = theme.number == "plural" or theme.quantifier in WORDS["universal"]
    return _are_needed(tree, node) or (several and not is_put_later(tree, node))


def _are_needed(tree: Tree, node: int) -> bool:
    """Check that the next clause about a load is about another one, which the forks can't hold."""
    named = objects(tree, node)
    after = next((n for n in asked(tree) if n > node and objects(tree, n)), None)
    if not named or after is None or negated(tree.nodes[after]):
        return False
    moves = tree.below(after, _ARGUMENTS, "PLACE", "PATH")
    if not (moves or tree.verbs[after].classes & HANDLING_VERBS):
        return False
    following = tree.nodes[objects(tree, after)[0]]
    same = noun_words(following)[-1:] == noun_words(tree.nodes[named[0]])[-1:]
    return not (same or is_pronoun(following) or is_nounless(noun_leaf(following)))


def _is_spoken_of(tree: Tree, named: Sequence[int]) -> bool:
    return len(named) == 1 and is_pronoun(tree.nodes[named[0]])


def _has_led(tree: Tree, node: int) -> bool:
    """Check that an earlier clause says where to: "bring it to the truck and load it"."""
    before = (n for n in asked(tree) if n < node and tree.nodes[n].type == "EVENT")
    return any(
        goal_places(tree, n) or any(is_goal(tree.nodes[p]) for p in goal_paths(tree, n))
        for n in before
    )


def _is_down(place: SDC) -> bool:
    """Check that a place is only the ground, or "there"."""
    if is_there(place):
        return True
    return len(place.landmark1) == 1 and is_floor(place.landmark1[0]) and not place.landmark2


def _is_end(tree: Tree, node: int) -> bool:
    return bool(WORDS["until"].intersection(bare_words(all_words(tree.nodes[node]))))


def _guessed(*, theme: bool, leads: bool) -> frozenset[str]:
    """Return the classes of an unknown verb by its arguments; the forks' load tells the rest."""
    if theme:
        return frozenset(("carrying",) if leads else ("taking", "placing"))
    return frozenset(("going",))


def leads_aboard(tree: Tree, own: Frame, labels: Collection[str]) -> bool:
    """Check that a clause leads onto the robot, which has some labels: "onto your forklift".

    But not where it leads elsewhere, too: "put the pallet on your forks on the truck".
    """
    robot = {normalise(label) for label in labels}

    def is_aboard(node: int) -> bool:
        words = set(_relation(tree, node))
        marks = [tree.nodes[n] for n in tree.below(node, _ARGUMENTS, "OBJECT")]
        named = any(names_forks(m) or robot.intersection(figure_words(m)) for m in marks)
        return named and words <= WORDS["aboard"] and words != {"to"}

    goals = (*own.places, *own.paths)
    return bool(goals) and all(map(is_aboard, goals))


def spares(tree: Tree, node: int, held: str | None) -> bool:
    """Check that a clause tells what to leave alone: "leave the crate", with nothing on the forks.

    But not "leave it on the truck". "Leave it here", "leave it where it is" and "leave the one
    closest to you" do.
    """
    words = set(_relation(tree, node))
    if not words & WORDS["leaving"]:
        return False
    where = [tree.nodes[n] for n in frame(tree, node).places]
    stays = any(
        not {"where", *WORDS["nearest"]}.isdisjoint(field_words(sdc.relation))
        or WORDS["start"].issuperset(bare_words(all_words(sdc)))
        for sdc in where
    )
    alone = stays or not frame(tree, node).places
    return bool(words & {"alone", "be"}) or (held is None and alone)


def later(tree: Tree, node: int) -> Iterator[Frame]:
    """The frames of the clauses after one."""
    order = asked(tree)
    after = order[order.index(node) + 1 :] if node in order else ()
    return (frame(tree, n) for n in after if tree.nodes[n].type == "EVENT")


def is_put_later(tree: Tree, node: int) -> bool:
    """Check that a later clause puts something down, whatever it is."""
    return any(_puts(own) for own in later(tree, node))


def _puts(own: Frame) -> bool:
    return own.places_load and not own.guessed


def told_side(tree: Tree, node: int) -> str:
    """The side that the robot has been told to go to when a clause begins, or is in it.

    "Swing left and proceed to the truck" speaks of a truck on the left. What something is picked
    up from or put down at tells nothing of the next thing.
    """
    found = ""
    order = asked(tree)
    for n in order[: order.index(node) + 1]:
        if tree.nodes[n].type != "EVENT":
            continue
        own = frame(tree, n)
        if n != node and own.handles:
            found = ""
        if n == node or own.classes & {"going", "turning"}:
            named = own.directions & {"left", "right"}
            found = min(named) if len(named) == 1 else found
    return found
