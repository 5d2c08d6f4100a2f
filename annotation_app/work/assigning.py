"""Items for some people or groups only: each for all of them, or shared out among them.

A group is a name in the profiles of its members, of all studies.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Literal, TypeAlias, get_args

from sqlalchemy import delete, exists, func, select
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.core.sent_text import clean_text
from annotation_app.items.new_items import REPLACED
from annotation_app.store.audit import note
from annotation_app.store.models import Answer, Assignment, Item, Person, Slot, Study, TaskName
from annotation_app.studies.study_file import LONGEST_GROUP, restored

Way: TypeAlias = Literal["share", "each", "anybody"]
WAYS: tuple[Way, ...] = get_args(Way)
"""Shared out evenly; each item for all of them; for anybody again."""
_GROUPS = "groups"


def assign(
    session: Session,
    study: Study,
    task: TaskName,
    people: Sequence[str],
    in_groups: Sequence[str] = (),
    *,
    actor: str,
    way: Way,
    video: str = "",
) -> int:
    """Assign the open items of a task, or of one of its videos, to people, and groups by name.

    Where they are shared out, each item goes to as many people as it wants answers.

    Returns
    -------
    int
        The number of items.
    """
    config = restored(study.config)
    if way == "anybody" and config.groups:
        raise Refusal(422, "The study gives its items to groups. Change these in its set-up.")
    known = groups(session)
    for group in in_groups:
        if group not in known:
            raise Refusal(
                422, f"There is no group {group}. There are: {', '.join(known) or 'none'}."
            )
    among = {*people, *(member.id for group in in_groups for member in known[group])}
    chosen = [person.id for person in assignable(session, study.id) if person.id in among]
    found = (
        select(Item.id, func.count(Slot.id))
        .join(Slot, Slot.item_id == Item.id)
        .where(
            Item.study_id == study.id,
            Item.task == task,
            Item.attention.is_(False),
            ~Item.subject.startswith(REPLACED),
            *((Item.video == video,) if video else ()),
        )
        .group_by(Item.id)
        .having(func.count(Slot.id).filter(Slot.answered.is_(False)) > 0)
        .order_by(Item.rank, Item.id)
    )
    items = session.execute(found).all()
    most = max((wanted for _, wanted in items), default=1)
    if way != "anybody" and len(chosen) < most:
        raise Refusal(422, f"Choose {most} people or more: an item wants so many answers.")
    first = 0
    for item_id, wanted in items:
        session.execute(delete(Assignment).where(Assignment.item_id == item_id))
        if way == "each":
            whose = chosen
        elif way == "share":
            whose = [chosen[(first + i) % len(chosen)] for i in range(wanted)]
            first += wanted
        else:
            whose = []
        session.add_all(Assignment(item_id=item_id, person_id=one) for one in whose)
    session.flush()
    note(
        session,
        actor,
        "assigned items",
        study.name,
        task=task,
        items=len(items),
        people=len(chosen) if way != "anybody" else 0,
        way=way,
    )
    return len(items)


def share_among_groups(session: Session, study: Study) -> None:
    """Assign the items that nobody has or has answered to the groups of a study's file.

    Each goes to the group that is furthest behind its share of the task's items, and there to those
    who have the fewest. While a group has fewer members than an item wants answers, its items are
    for anybody.
    """
    shares = restored(study.config).groups
    if not shares:
        return
    members = {name: [one.id for one in found] for name, found in groups(session).items()}
    mine = (Item.study_id == study.id, Item.attention.is_(False))
    assigned_to = (
        select(Item.task, Assignment.person_id, func.count())
        .join(Item, Item.id == Assignment.item_id)
        .where(*mine)
        .group_by(Item.task, Assignment.person_id)
    )
    load = Counter({(task, one): count for task, one, count in session.execute(assigned_to)})
    unassigned = (
        select(Item, func.count(Slot.id))
        .join(Slot, Slot.item_id == Item.id)
        .where(
            *mine,
            ~Item.subject.startswith(REPLACED),
            ~exists().where(Assignment.item_id == Item.id),
        )
        .group_by(Item.id)
        .having(func.count(Slot.id).filter(Slot.answered) == 0)
        .order_by(Item.task, Item.rank, Item.id)
    )
    left_over: Counter[tuple[TaskName, str]] = Counter()
    for item, wanted in session.execute(unassigned).all():
        had = {
            name: left_over[item.task, name]
            + sum(load[item.task, one] for one in members.get(name, ())) / wanted
            for name in shares
        }
        each = (sum(had.values()) + 1) / sum(shares.values())
        group = max(shares, key=lambda name: shares[name] * each - had[name])
        able = [one for one in members.get(group, ()) if one != item.author_id]
        able.sort(key=lambda one: load[item.task, one])
        if len(able) < wanted:
            left_over[item.task, group] += 1
            continue
        load.update((item.task, one) for one in able[:wanted])
        session.add_all(Assignment(item_id=item.id, person_id=one) for one in able[:wanted])
    session.flush()


def assignable(session: Session, study_id: str) -> Sequence[Person]:
    """Return the people to whom items may be assigned: with a login, a group, or answers."""
    answering = select(Answer.person_id).where(Answer.study_id == study_id)
    return session.scalars(
        select(Person)
        .where(
            Person.blocked_at.is_(None),
            Person.login.is_not(None) | Person.id.in_(answering) | _IN_GROUPS,
        )
        .order_by(Person.login, Person.external_hash)
    ).all()


def groups(session: Session) -> dict[str, list[Person]]:
    """Return the members of each group, by its name."""
    found: dict[str, list[Person]] = {}
    members = select(Person).where(_IN_GROUPS).order_by(Person.login, Person.external_hash)
    for person in session.scalars(members):
        for group in person.profile[_GROUPS]:
            found.setdefault(group, []).append(person)
    return dict(sorted(found.items()))


def group_sizes(session: Session) -> dict[str, int]:
    """Return the number of members of each group, by its name."""
    return {name: len(members) for name, members in groups(session).items()}


def set_group(session: Session, name: str, people: Sequence[str], *, actor: str) -> str:
    """Make a group of exactly these people, by their ids; without people there is none any more.

    Returns
    -------
    str
        The name as it is kept.
    """
    name = clean_text(name)
    if not name or len(name) > LONGEST_GROUP:
        raise Refusal(422, f"Give the group a name of at most {LONGEST_GROUP} characters.")
    before = groups(session).get(name, [])
    chosen = session.scalars(select(Person).where(Person.id.in_(people))).all()
    for person in {*before, *chosen}:
        names = {*person.profile.get(_GROUPS, []), name}
        if person not in chosen:
            names.remove(name)
        rest = {key: value for key, value in person.profile.items() if key != _GROUPS}
        person.profile = {**rest, _GROUPS: sorted(names)} if names else rest
    session.flush()
    for study in session.scalars(select(Study).where(Study.closed_at.is_(None))).all():
        if name in study.config.get(_GROUPS, ()):
            share_among_groups(session, study)
    note(session, actor, "changed a group", name, people=len(chosen))
    return name


_IN_GROUPS = Person.profile[_GROUPS].as_string().is_not(None)


def assigned(session: Session, study_id: str) -> Counter[tuple[str, TaskName]]:
    """Count the open items that are assigned to each person, by their ids and the task."""
    open_ = exists().where(Slot.item_id == Item.id, Slot.answered.is_(False))
    rows = session.execute(
        select(Assignment.person_id, Item.task, func.count())
        .join(Item, Item.id == Assignment.item_id)
        .where(Item.study_id == study_id, open_)
        .group_by(Assignment.person_id, Item.task)
    )
    return Counter({(person_id, task): count for person_id, task, count in rows})
