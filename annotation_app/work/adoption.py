"""From the answers of one task to the items of the next.

Where a task has an adjudication, the study's rule adopts an answer once all that were wanted are
there: if all agree, or enough of them. Else an adjudicator adopts one. Other answers are adopted at
once.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from sqlalchemy import String, bindparam, cast, delete, exists, literal, select
from sqlalchemy.orm import Session, aliased

from annotation_app.items.item_scenes import has_things
from annotation_app.items.new_items import REPLACED, about_answer, add_item, videos_of
from annotation_app.items.submissions import add_event
from annotation_app.store.models import Answer, Item, Person, Record, Slot, Study, TaskName
from annotation_app.studies.study_file import TaskConfig, restored
from annotation_app.tasks.task_registry import makers, task_of, tasks
from annotation_app.work.answer_flags import odd_below
from annotation_app.work.answer_reading import gist_of
from annotation_app.work.assigning import share_among_groups

ROUNDING = 1e-9

_ANSWERED = (
    select(Answer, Item, Study)
    .join(Item, Item.id == Answer.item_id)
    .join(Study, Study.id == Item.study_id)
    .where(Answer.id == bindparam("answer"))
    # One at a time, or of two who agree at the same moment neither sees the other's answer.
    .with_for_update(key_share=True, of=Item)
)


def answered(session: Session, task: TaskName, answer_id: int) -> None:
    """Make the next items of an accepted answer, or decide about its item."""
    adjudication = task_of(task).adjudication
    if adjudication is None and not makers(task_of(task).gives):
        return
    answer, item, study = session.execute(_ANSWERED, {"answer": answer_id}).one()
    if adjudication is not None:
        settle(session, study, item)
    else:
        _go_on(session, study, item, answer)


def settle(session: Session, study: Study, item: Item) -> None:
    """Adopt one of an item's answers if none is, all wanted ones are there, and enough agree."""
    adjudication = task_of(item.task).adjudication
    rule = restored(study.config).tasks.get(item.task, TaskConfig()).adoption
    if adjudication is None or rule == "adjudicator":
        return
    answers = session.scalars(
        select(Answer)
        .where(Answer.item_id == item.id, Answer.excluded.is_(False))
        .order_by(Answer.id)
    ).all()
    open_ = select(Slot.id).where(Slot.item_id == item.id, Slot.answered.is_(False)).limit(1)
    if any(answer.adopted for answer in answers) or session.scalar(open_) is not None:
        return
    wanted = [answer for answer in answers if not answer.surplus]
    alike: list[list[Answer]] = []
    for answer in wanted:
        essence = adjudication.essence(answer.body)
        same = [group for group in alike if adjudication.essence(group[0].body) == essence]
        if same:
            same[0].append(answer)
        else:
            alike.append([answer])
    most = max(alike, key=len, default=[])
    if most and _suffices(rule, len(most), len(wanted)):
        adopt(session, study, item, most[-1])


def _suffices(rule: str | float, alike: int, wanted: int) -> bool:
    """Check that enough of the wanted answers are alike."""
    if rule == "majority":
        return 2 * alike > wanted
    return alike >= (wanted if isinstance(rule, str) else rule * wanted - ROUNDING)


def settle_open(session: Session, study: Study, task: TaskName) -> None:
    """Decide about the items of a task that await a decision, by a rule that is new."""
    undecided = select(Item).where(
        Item.study_id == study.id,
        Item.task == task,
        ~Item.subject.startswith(REPLACED),
        exists().where(Answer.item_id == Item.id),
        ~exists().where(Answer.item_id == Item.id, Answer.adopted),
    )
    for item in session.scalars(undecided.order_by(Item.id)).all():
        settle(session, study, item)


def adopt(session: Session, study: Study, item: Item, answer: Answer) -> None:
    """Take an answer as the right one, in place of any other, and make the next items of it.

    Nobody gets the items any more that were made of the answer that it replaces.
    """
    if answer.adopted:
        return
    if task_of(item.task).adjudication is not None:
        replaced = session.scalars(
            select(Answer).where(
                Answer.item_id == item.id, Answer.adopted.is_(True), Answer.id != answer.id
            )
        ).all()
        for other in replaced:
            other.adopted = False
        _withdraw(session, item, [*replaced, answer])
    answer.adopted = True
    session.flush()
    _go_on(session, study, item, answer)


def adjudicate(
    session: Session,
    study: Study,
    item: Item,
    person: Person,
    *,
    uuid: str,
    sent: Record,
    body: Record,
    now: float,
) -> Answer:
    """Keep what an adjudicator answers to an item, and adopt it.

    They may think better of it: then they have another answer to the item in its place.
    """
    event = add_event(session, item, person.id, name="adjudicate", uuid=uuid, body=sent, now=now)
    answer = session.scalars(
        select(Answer).where(
            Answer.person_id == person.id,
            Answer.task == item.task,
            Answer.subject == item.subject,
        )
    ).first()
    if answer is None:
        answer = Answer(
            item_id=item.id,
            study_id=item.study_id,
            person_id=person.id,
            task=item.task,
            subject=item.subject,
            surplus=True,
            seconds=None,
        )
        session.add(answer)
    answer.event_id, answer.body, answer.at = event, body, now
    answer.kind = "attention" if item.attention else "adjudicated"
    answer.gist = gist_of(item.task, body)
    answer.odd_below_s = odd_below(item.payload, body, answer.provenance)
    answer.adopted = answer.excluded = False
    session.flush()
    adopt(session, study, item, answer)
    return answer


def _go_on(session: Session, study: Study, item: Item, answer: Answer) -> None:
    """Make the next items of an answer that is adopted."""
    config = restored(study.config)
    gives = task_of(item.task).gives
    for task in makers(gives):
        for source in task.sources:
            if source.made_of == gives and task.name in config.tasks:
                for new in source.items(session, config, item, answer):
                    add_item(session, study, config, new)
    share_among_groups(session, study)


def catch_up(session: Session, study: Study, added: Collection[TaskName] = ()) -> None:
    """Make the items that adopted answers lack.

    They lack those of the tasks that a study has been `added`, and those about things that weren't
    known when the answers came.
    """
    config = restored(study.config)
    known = [v for v in videos_of(session, study.id) if has_things(session, study.id, v)]
    about = literal("answer ") + cast(Answer.id, String)
    made = aliased(Item)
    for task in (task for task in tasks() if task.name in config.tasks):
        is_new = task.name in added
        for source in task.sources if is_new else (task.source,):
            if source is None or not (is_new or task.needs_scenes):
                continue
            lacking = (
                select(Answer, Item)
                .join(Item, Item.id == Answer.item_id)
                .where(
                    Answer.study_id == study.id,
                    Answer.task.in_([one.name for one in tasks() if one.gives == source.made_of]),
                    Answer.adopted.is_(True),
                    Answer.excluded.is_(False),
                    ~exists().where(
                        made.study_id == study.id, made.task == task.name, made.subject == about
                    ),
                    *(() if is_new else (Item.video.in_(known),)),
                )
                .order_by(Answer.id)
            )
            for answer, item in session.execute(lacking).all():
                for new in source.items(session, config, item, answer):
                    add_item(session, study, config, new)


def _withdraw(session: Session, item: Item, answers: Sequence[Answer]) -> None:
    """Let nobody get what was made of answers any more, and make their subjects free."""
    made = [task.name for task in makers(task_of(item.task).gives)]
    for answer in answers:
        items = select(Item).where(
            Item.study_id == item.study_id,
            Item.subject == about_answer(answer),
            Item.task.in_(made),
        )
        for one in session.scalars(items).all():
            session.execute(delete(Slot).where(Slot.item_id == one.id, Slot.answered.is_(False)))
            one.subject = f"{REPLACED}{one.id}"
    session.flush()
