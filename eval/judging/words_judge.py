"""The second verdict: agreement of an execution with the command's words, wherever the log ends.

It shares nothing with the judged system: it reads annotated clauses (or clauses that it is given,
whose nouns name things by their labels), with its own table of words and its own geometry. Any
thing, side or place that the words allow is right. A requested action that is missing is wrong, and
so is an action on a thing that the words don't mention. There is no verdict without clauses, or
where they state something that can't be measured.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from eval.judging import layout
from eval.judging.execution import Carried, Execution
from eval.judging.grounded_command import (
    HANDLING,
    SIDES,
    GroundedCommand,
    Request,
    grounded_clauses,
    grounded_command,
    requests,
)
from eval.judging.judge import Verdict
from eval.judging.layout import SHORT_M, Things, prisms
from g3.actions.robot_state import State, moved_to
from g3.annotation import Annotation
from g3.geometry.footprints import apart, centre
from g3.geometry.relations import (
    BESIDE_M,
    NEAR_M,
    PASSED_M,
    goes,
    in_frame,
    in_region,
    is_between,
    is_carrier,
    nearest,
    on_side,
    same_level,
)
from g3.groundings import FloatArray, Place, Prism
from g3.sdc.clauses import SDC
from g3.short_repr import short_repr

ROWS = 60
"""Number of points of the path at which positions are checked."""
NOT_ANNOTATED = "it can't judge: the command has no annotated clauses"
UNMEASURABLE = "it can't judge: the clauses state nothing that it can measure"
LATERAL = frozenset({"left", "right"})
_PLACING = SIDES | set("123456789") | {"on", "between", "near", "far", "end", "empty", "alone"}


def judge_by_words(annotation: Annotation | None, execution: Execution) -> Verdict | None:
    """Compare an execution, in the command's own world or another, with its annotated clauses.

    None if the command isn't annotated, or if its clauses state nothing that can be measured.
    """
    if annotation is None:
        return None
    return _verdict(grounded_command(annotation, execution.start), execution)


def why_not_judged(annotation: Annotation | None) -> str:
    """Return why :func:`judge_by_words` has no verdict."""
    return UNMEASURABLE if annotation else NOT_ANNOTATED


def judge_clauses(sdcs: Sequence[SDC], execution: Execution) -> Verdict | None:
    """Compare an execution with clauses that nobody has grounded; None if it can't be judged.

    :func:`g3.sdc.sdc_notation.parse_brackets` reads clauses in bracket notation.
    """
    return _verdict(grounded_clauses(sdcs, execution.start), execution)


def _verdict(command: GroundedCommand, execution: Execution) -> Verdict | None:
    clauses = requests(command)
    if not clauses or not all(request.is_clear for request in clauses):
        return None
    handles = any(request.handles for request in clauses)
    try:
        reason = (_mishandled if handles else _misdriven)(command, clauses, execution)
    except _UnmeasurableError:
        return None
    return Verdict(not reason, reason)


class _UnmeasurableError(Exception):
    """The words state something that can't be measured."""


def _misdriven(command: GroundedCommand, clauses: Sequence[Request], execution: Execution) -> str:
    """Return the error of a command that only drives; empty if there is none."""
    if any(c.id != execution.start.held or c.lowered is not None for c in execution.carried):
        return "it moves a load, of which the words don't speak"
    if any(request.verbs != {"stay"} for request in clauses) and not _drives(execution.way):
        return "the robot stays where it is"
    return _astray(command, clauses, execution)


def _mishandled(command: GroundedCommand, clauses: Sequence[Request], execution: Execution) -> str:
    """Return the error of a command that handles a load; empty if there is none."""
    themes = _themes(command, clauses)
    theme_ids = frozenset(i for ids in themes.values() for i in ids)
    strange = [c.id for c in execution.carried if themes and c.id not in theme_ids]
    if strange:
        return f"it moves {', '.join(strange)}, which the words don't speak of"
    counts = {theme: 1 if command.by_labels else len(theme) for theme in themes}
    if len(execution.carried) > max(sum(counts.values()), 1):
        return "it moves more than the words say"
    for theme, ids in themes.items() if themes else [(None, None)]:
        loads = [c for c in execution.carried if ids is None or c.id in ids]
        if len(loads) < (1 if theme is None else max(counts[theme], 1)):
            return "it doesn't move what the words say"
        mine = [r for r in clauses if r.handles and (theme is None or theme in r.themes)]
        for load in loads:
            reason = _misplaced(command, mine, load, execution)
            if reason:
                return reason
    return _astray(command, clauses, execution)


def _themes(command: GroundedCommand, clauses: Sequence[Request]) -> dict[Things, Things]:
    """Map annotated loads to all that the words allow instead."""
    result: dict[Things, Things] = {}
    for theme in (theme for request in clauses for theme in request.themes):
        naming = [n for n in _outermost(command, theme) if not command.is_pronoun(n)]
        sets = [allowed(command, n) for n in naming]
        here = next(t for a, t in zip(command.annotated, command.things, strict=True) if a == theme)
        result[theme] = frozenset.intersection(*sets) if sets else here
    return result


def _outermost(command: GroundedCommand, things: Things) -> list[int]:
    nodes = [n for n, sdc in enumerate(command.nodes) if sdc.type == "OBJECT"]
    nodes = [n for n in nodes if command.annotated[n] == things]
    inside = {c for n in nodes for field in command.children[n].values() for c in field}
    return [n for n in nodes if n not in inside]


@short_repr
@dataclass(frozen=True, slots=True)
class Standing:
    """An object's position and shape before and after an execution."""

    thing: str
    """Id of the object."""
    first: Prism
    last: Prism
    """Shapes at the start and at the end."""
    state: State
    short: bool = False
    """True if the load is still on the forks at the end."""
    robot: bool = False

    @property
    def under(self) -> str | None:
        """Id of the supporting object; None for the ground."""
        return layout.support(self.state, self.last, self.thing)

    @property
    def slack(self) -> float:
        """Additional tolerance, in metres."""
        return SHORT_M if self.short else 0.0

    def is_in(self, places: Iterable[Place]) -> bool | None:
        """Check that it is in one of several regions; None without a region."""
        margin = layout.ROBOT_REGION_M if self.robot else layout.REGION_M
        return in_region(self.last, places, margin + self.slack)


@dataclass(frozen=True)
class Relation:
    """The meanings of a relation's words, with its landmarks."""

    command: GroundedCommand
    says: frozenset[str]
    marks: tuple[int, ...] = ()
    """Clauses of its landmarks."""

    @cached_property
    def objects(self) -> list[int]:
        """The landmarks that are OBJECTs, and no areas."""
        nodes, is_area = self.command.nodes, self.command.is_area
        return [n for n in self.marks if nodes[n].type == "OBJECT" and not is_area(n)]

    @cached_property
    def areas(self) -> list[int]:
        """The landmarks that are areas: "on the ground"."""
        nodes, is_area = self.command.nodes, self.command.is_area
        return [n for n in self.marks if nodes[n].type == "PLACE" or is_area(n)]

    @cached_property
    def landmarks(self) -> Things:
        """Things that the landmarks' words allow."""
        return frozenset(i for n in self.objects for i in allowed(self.command, n))

    @property
    def missing(self) -> bool:
        """True if a landmark isn't in this world."""
        labels, things = self.command.labels, self.command.things
        return any(labels[n] and not things[n] for n in self.objects)

    @property
    def of_robot(self) -> bool:
        """True if it is about the robot, or has no landmark."""
        named = any(map(self.command.is_robot, self.objects))
        return named or not self.objects or self.landmarks == {self.command.robot}

    @property
    def regions(self) -> list[Place]:
        """Annotated regions of its landmarks."""
        return [place for n in self.objects for place in self.command.places[n]]

    @property
    def side(self) -> str | None:
        """The side that it names, if it is one."""
        sides = self.says & SIDES
        return next(iter(sides)) if len(sides) == 1 else None

    @property
    def number(self) -> int | None:
        """Place in an order, counted from its side; 1 for the leftmost."""
        number = next((int(m) for m in self.says if m.isdigit()), None)
        return number or (1 if self.side in LATERAL and self.says & {"extreme", "end"} else None)

    def around(self, standing: Standing) -> list[Prism]:
        """Return the shapes of the landmarks at the end, without the robot and the thing itself."""
        things = self.landmarks - {self.command.robot, standing.thing}
        return prisms(standing.state, things) + [place.prism for place in self.regions]

    def peers(self, standing: Standing) -> list[Prism]:
        """Return the landmarks, and things of their kinds, where they are at the end."""
        alike = frozenset(i for n in self.objects for i in self.command.alike(n))
        return prisms(standing.state, (self.landmarks | alike) - {standing.thing})

    def holds(self, standing: Standing) -> bool | None:
        """Check that something stands so; None if that can't be measured."""
        if self.missing:
            return False
        around = self.around(standing)
        if self.regions and not self.says & (SIDES | {"near", "between"}):
            return standing.is_in(self.regions)
        if not around:
            return self._aside(standing) if self.of_robot else None
        check = next((c for meaning, c in _CHECKS.items() if self._means(meaning)), None)
        return check(self, standing, around) if check else None

    def _means(self, meaning: str) -> bool:
        if meaning == "side":
            return self.side is not None
        return meaning in self.says and not (meaning == "on" and self.says & LATERAL)

    def _aside(self, standing: Standing) -> bool | None:
        """Check for a position or a movement to one side of the robot, as the robot sees it."""
        if self.side is None or standing.short:
            return None
        ends = np.array([centre(p) for p in (standing.first, standing.last)])
        first, last = in_frame(ends, self.command.state.pose)
        return goes(self.side, last) or goes(self.side, last - first)


def _at_end(relation: Relation, standing: Standing, around: Sequence[Prism]) -> bool:
    near = nearest(standing.last, around) - standing.slack <= NEAR_M
    return near and not is_between(standing.last, relation.peers(standing))


def _between(relation: Relation, standing: Standing, around: Sequence[Prism]) -> bool:
    close = standing.short and nearest(standing.last, around) <= standing.slack
    return close or is_between(standing.last, around)


def _on(relation: Relation, standing: Standing, around: Sequence[Prism]) -> bool:
    close = standing.short and nearest(standing.last, around) <= standing.slack
    return close or standing.under in relation.landmarks


def _on_side(relation: Relation, standing: Standing, around: Sequence[Prism]) -> bool | None:
    """Check the side of landmarks; a load's side on a deck isn't measured."""
    if standing.under in relation.landmarks:
        return None
    if standing.short:
        return nearest(standing.last, around) - standing.slack <= NEAR_M
    pose = relation.command.state.pose
    return on_side(standing.last, relation.side or "", around, pose)


def _closer(relation: Relation, standing: Standing, around: Sequence[Prism]) -> bool:
    first = nearest(standing.first, around)
    return nearest(standing.last, around) <= max(BESIDE_M, first - layout.DRIVEN_M)


def _near(relation: Relation, standing: Standing, around: Sequence[Prism]) -> bool:
    reach = nearest(standing.last, around) - standing.slack
    limit = NEAR_M if "far" in relation.says else BESIDE_M
    return standing.under in relation.landmarks or reach <= limit


_CHECKS: dict[str, Callable[[Relation, Standing, Sequence[Prism]], bool | None]] = {
    "end": _at_end,
    "between": _between,
    "on": _on,
    "side": _on_side,
    "toward": _closer,
    **dict.fromkeys(("near", "to", "far", "with"), _near),
}
"""Meanings with their checks. The first meaning that a relation has counts."""


def ends_well(command: GroundedCommand, nodes: Iterable[int], standing: Standing) -> bool | None:
    """Check an end against several clauses; None if none of them can be measured."""
    checks = [holds for n in nodes if (holds := _holds(command, n, standing)) is not None]
    return all(checks) if checks else None


def _holds(command: GroundedCommand, node: int, standing: Standing) -> bool | None:
    """Check an end against one clause; None if it can't be measured.

    In the annotated world the annotated region is right, too, regardless of the words.
    """
    places = command.places[node]
    region = standing.is_in(places)
    if places and not (standing.robot or standing.short):
        level = any(same_level(place.prism, standing.last) for place in places)
        region = bool(region) and level
    if command.own and region:
        return True
    related = _related(command, node, standing)
    return region if related is None else related


def _related(command: GroundedCommand, node: int, standing: Standing) -> bool | None:
    sdc = command.nodes[node]
    if sdc.type == "OBJECT" and not command.is_area(node):
        # "Until you reach the truck" leads to the truck.
        return Relation(command, frozenset({"to"}), (node,)).holds(standing)
    if sdc.type == "OBJECT" and sdc.is_leaf:
        return standing.short or standing.under is None
    relation = _relation(command, node)
    if relation.areas:
        inside = _in_areas(command, relation.areas, standing)
        if inside is not None or not relation.objects:
            return inside
    return relation.holds(standing)


def _relation(command: GroundedCommand, node: int) -> Relation:
    """Return a clause's relation, with landmarks that name a relation: "in the middle"."""
    marks = tuple(command.below(node, "OBJECT", "PLACE", "PATH", "EVENT"))
    leaves = (n for n in marks if not command.annotated[n] and command.nodes[n].is_leaf)
    says = command.meanings(node).union(*map(command.meanings, leaves))
    return Relation(command, says, marks)


def _in_areas(command: GroundedCommand, areas: Sequence[int], standing: Standing) -> bool | None:
    """Check that an end lies in an area used as a place: "the ground by the truck"."""
    ground = any("ground" in command.meanings(f) for n in areas for f in command.figures(n))
    if ground and not standing.short and standing.under is not None:
        return False
    stated = [n for n in areas if command.nodes[n].relation or command.places[n]]
    inside = ends_well(command, stated, standing)
    return True if ground and inside is None else inside


def allowed(command: GroundedCommand, node: int) -> Things:
    """Return the ids of objects that an OBJECT's words allow; none if it isn't grounded.

    A modifier that can't be measured allows only the annotated thing. In the annotated world this
    thing is always allowed.
    """
    here = command.things[node]
    if not command.annotated[node] or command.robot in here or command.is_pronoun(node):
        return here
    fitting, is_measured = command.alike(node), True
    for modifier in _modifiers(command, node):
        selected = _select(modifier, fitting)
        is_measured &= selected is not None
        fitting = fitting if selected is None else selected
    if command.own:
        return here | fitting if is_measured else here
    return fitting if is_measured else fitting & here


def _modifiers(command: GroundedCommand, node: int) -> list[Relation]:
    """Return an OBJECT's modifiers; those of order are one: "the second" "from the right"."""
    modifiers = [_relation(command, n) for n in command.figures(node) if not command.names_same(n)]
    order = [m for m in modifiers if m.number or m.side in LATERAL]
    rest = [m for m in modifiers if m not in order]
    if order:
        concepts = frozenset(w for m in order for w in m.says)
        rest.append(Relation(command, concepts, tuple(n for m in order for n in m.marks)))
    return rest


def _select(modifier: Relation, fitting: Things) -> Things | None:
    """Select the things that a modifier fits; None if that can't be measured."""
    command, says = modifier.command, modifier.says
    unclear = "not" in says or any(command.nodes[n].type != "OBJECT" for n in modifier.marks)
    if modifier.missing:
        return frozenset()
    if "toward" in says and not modifier.landmarks:
        return fitting  # what is to go to a side needn't stand there
    if not says & _PLACING:
        return fitting if modifier.of_robot else None
    if unclear:
        return None
    ordered = _ordered(modifier, fitting)
    return _placed(modifier, fitting) if ordered is None else ordered


def _placed(modifier: Relation, fitting: Things) -> Things | None:
    """Select things by words about them alone or about the robot, or by where they stand."""
    command, says = modifier.command, modifier.says
    select = next((s for meaning, s in _SELECTORS.items() if meaning in says), None)
    if select and modifier.of_robot and not modifier.areas:
        return select(command, fitting)
    checks: dict[str, bool | None] = {}
    for i in fitting:
        shape = command.state.thing(i).prism
        standing = Standing(i, shape, shape, command.state)
        inside = _in_areas(command, modifier.areas, standing) if modifier.areas else None
        checks[i] = modifier.holds(standing) if inside is None else inside
    return None if None in checks.values() else frozenset(i for i in checks if checks[i])


def _ordered(modifier: Relation, fitting: Things) -> Things | None:
    """Select things on a side, or by their number from it: of all, on a thing, or in a row.

    None if no words of order apply.
    """
    side, number = modifier.side if modifier.side in LATERAL else None, modifier.number
    state, group = modifier.command.state, modifier.landmarks - {modifier.command.robot}
    on = frozenset(i for i, under in layout.supports(state, fitting).items() if under in group)
    among = on or (group & fitting)
    if not (side or number) or (group and not among):
        return None
    rows = layout.in_rows(state, among or fitting)
    chosen = {i for row in rows for i in _counted(layout.from_left(state, row), side, number)}
    return fitting & chosen


def _counted(order: Sequence[str], side: str | None, number: int | None) -> list[str]:
    """Select things by their place from a side, from either if none is given; else half of them."""
    chosen = []
    for place, thing in enumerate(order, start=1):
        counts = {"left": (place,), "right": (len(order) + 1 - place,)}
        places = counts.get(side or "", (place, len(order) + 1 - place))
        half = len(order) == 1 or 2 * places[0] < len(order) + 1
        if number in places or (not number and half):
            chosen.append(thing)
    return chosen


def _of_kind(command: GroundedCommand, ids: Things) -> Things:
    """Return things that share a label with some of those given, and these."""
    labels = {label for i in ids for label in command.state.thing(i).labels}
    things = command.state.context.objects
    return frozenset(o.id for o in things if o.id != command.robot and labels & set(o.labels))


def _empty(command: GroundedCommand, fitting: Things) -> Things:
    everything = [o.id for o in command.state.context.objects]
    return fitting - frozenset(filter(None, layout.supports(command.state, everything).values()))


def _alone(command: GroundedCommand, fitting: Things) -> Things:
    state, peers = command.state, _of_kind(command, fitting)
    gaps = {i: nearest(state.thing(i).prism, prisms(state, peers - {i})) for i in fitting}
    return frozenset(i for i in fitting if gaps[i] == max(gaps.values()))


def _inside_row(command: GroundedCommand, fitting: Things) -> Things:
    rows = layout.in_rows(command.state, _of_kind(command, fitting))
    return fitting & {i for row in rows for i in layout.from_left(command.state, row)[1:-1]}


_SELECTORS: dict[str, Callable[[GroundedCommand, Things], Things]] = {
    "empty": _empty,
    "alone": _alone,
    "between": _inside_row,
    "back": lambda c, fitting: layout.straight_ahead(c.state, fitting, -1),
    "front": lambda c, fitting: layout.straight_ahead(c.state, fitting),
    "on": lambda c, fitting: fitting & {c.state.held or ""},
    "far": lambda c, fitting: layout.by_distance(c.state, fitting, far=True),
    "near": lambda c, fitting: layout.by_distance(c.state, fitting, far=False),
}
"""Meanings of words about things alone or about the robot, with the things that they select.

The first meaning that a modifier has counts."""


def _misplaced(
    command: GroundedCommand, clauses: Sequence[Request], load: Carried, execution: Execution
) -> str:
    """Return the error in how a load is handled; later handling is no error."""
    sources = [n for request in clauses for n in request.sources]
    if not all(_comes_from(command, node, load.id) for node in sources):
        return "it isn't taken from where the words say"
    first, last = execution.start.thing(load.id), execution.end.thing(load.id)
    held = load.lowered is None
    short = held and not execution.whole
    still = apart(first.prism, last.prism) < layout.LEFT_ALONE_M
    if held and still and load.id == execution.start.held:
        return "nothing is done with the load on the forks"
    verbs = clauses[-1].verbs & HANDLING
    if held and verbs == {"put"} and not (short and clauses[-1].goals):
        return "the load isn't put down"
    stated = [request.goals for request in clauses if request.goals]
    only_taken = not stated and all(r.verbs & HANDLING == {"take"} for r in clauses)
    if execution.whole and only_taken and not held:
        return "it puts down what it is only to pick up"
    if not stated:
        return ""
    standing = Standing(load.id, first.prism, last.prism, execution.end, short)
    holds = ends_well(command, stated[-1], standing)
    if holds is None:
        raise _UnmeasurableError
    return "" if holds else "the load doesn't end where the words say"


def _comes_from(command: GroundedCommand, node: int, load: str) -> bool:
    state, marks = command.state, command.below(node, "OBJECT")
    sources = frozenset(i for n in marks for i in allowed(command, n) | command.things[n])
    things = prisms(state, sources - {command.robot, load})
    if not things:
        return True
    under = layout.support(state, state.thing(load).prism, load)
    if under is not None:
        return under in sources
    # A load that is on the forks at first may have been taken from a deck before.
    near = nearest(state.thing(load).prism, things) <= NEAR_M
    return near and (load == state.held or not any(map(is_carrier, things)))


def _astray(command: GroundedCommand, clauses: Sequence[Request], execution: Execution) -> str:
    """Return the error in the robot's path; the requests' goals come in their order."""
    end = len(execution.way) - 1
    row, handles = 0, any(request.handles for request in clauses)
    moving = [request for request in clauses if request.verbs != {"stay"} or request.goals]
    measured = handles
    for request in moving:
        if request.handles:
            continue
        turned = _turns(request, execution, row)
        if turned is False:
            return "the robot doesn't turn as the words say"
        rows = np.unique(np.linspace(row, end, ROWS).astype(int)).tolist()
        passes = [_passes(command, n, execution, rows) for n in request.passed]
        if False in passes:
            return "the robot doesn't pass as the words say"
        last = request is moving[-1]
        goals = () if request.verbs == {"turn"} else request.goals
        reached = _reached(command, goals, execution, [end] if last else rows)
        if reached is False:
            return f"the robot doesn't {'end' if last else 'come'} where the words say"
        measured |= reached is not None or turned is not None or True in passes
        row = row if reached is None else int(reached)
    if not measured and moving:
        raise _UnmeasurableError
    return ""


def _reached(
    command: GroundedCommand, nodes: Sequence[int], execution: Execution, rows: Sequence[int]
) -> int | bool | None:
    """Return the first row at which clauses hold; False if none, None if unknown."""
    is_known = False
    for row in rows:
        holds = ends_well(command, nodes, _robot(execution, row))
        if holds:
            return row
        is_known |= holds is not None
    return False if is_known else None


def _passes(
    command: GroundedCommand, node: int, execution: Execution, rows: Sequence[int]
) -> bool | None:
    """Check that the robot comes near landmarks, and leaves behind what it is to drive past."""
    relation = _relation(command, node)
    gaps = [
        nearest(standing.last, relation.around(standing))
        for standing in (_robot(execution, row) for row in rows)
    ]
    if not relation.objects or not np.isfinite(gaps[-1]):
        return None
    behind = gaps[-1] > min(gaps) + layout.LEFT_ALONE_M
    stays = execution.whole and "beyond" in relation.says and not behind
    return bool(min(gaps) <= PASSED_M and not stays)


def _turns(request: Request, execution: Execution, row: int) -> bool | None:
    """Check for a turn or a drive to the side that is stated without a landmark."""
    if len(request.sides) != 1:
        return None
    [side], way = request.sides, execution.way[row:]
    if side in ("front", "back"):
        steps = np.diff(way[:, :2], axis=0)
        ahead = (steps * np.column_stack((np.cos(way[:-1, 2]), np.sin(way[:-1, 2])))).sum(axis=1)
        driven = np.maximum(ahead if side == "front" else -ahead, 0).sum()
        # A log may stop before that.
        return bool(driven >= layout.DRIVEN_M) if execution.whole else None
    turned = np.unwrap(way[:, 2]) * (1.0 if side == "left" else -1.0)
    far = any(goes(side, step, layout.DRIVEN_M) for step in in_frame(way[:, :2], way[0]))
    return bool((turned - turned[0]).max() >= layout.TURN or far)


def _drives(way: FloatArray) -> bool:
    """Check that the robot drives or turns at all."""
    far = np.linalg.norm(way[:, :2] - way[0, :2], axis=1).max() > layout.LEFT_ALONE_M
    return bool(far or np.ptp(np.unwrap(way[:, 2])) >= layout.TURN)


def _robot(execution: Execution, row: int) -> Standing:
    robot = execution.start.context.agent
    there = moved_to(robot, execution.way[row], robot.prism.z_min)
    state = execution.end if row == len(execution.way) - 1 else execution.start
    return Standing(robot.id, robot.prism, there.prism, state, robot=True)
