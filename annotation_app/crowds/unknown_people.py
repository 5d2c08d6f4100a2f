"""People who came by a platform's address, and whom it doesn't know: ids can be invented.

Their answers are left out, and their places go back to the queue. If the platform names them later,
their answers count again.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sqlalchemy import Engine, select
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.core.random_ids import new_id
from annotation_app.crowds.comparison import Deed
from annotation_app.people.participants import platform_knowledge, subject_of
from annotation_app.store.audit import COMMAND_LINE
from annotation_app.store.database import transaction
from annotation_app.store.installation import now
from annotation_app.store.models import Answer, Person, Remark, Study
from annotation_app.work.reviewing import exclude, restore

REASON = "The platform doesn't know this person."


def leave_out(engine: Engine, study: Study, provider: str) -> Iterator[Deed]:
    """Leave out what unknown people answered, and take back what of it is known now."""
    with transaction(engine) as session:
        knowledge = platform_knowledge(session, study.id)
        wanted = select(Person).where(Person.id.in_(knowledge), Person.provider == provider)
        for person in session.scalars(wanted.order_by(Person.id)).all():
            if knowledge[person.id] == "unknown":
                count = sum(_leave_out(session, study, a) for a in _answers(session, study, person))
                note = f"{count} left out, for the platform doesn't know who came"
            else:
                left = [a for a in _answers(session, study, person) if _was_left_out(session, a)]
                for answer in left:
                    restore(session, study, answer, _program(session), now=now())
                count = len(left)
                note = f"{count} count again, for the platform knows who came"
            if count:
                yield Deed(f"of {subject_of(person)}:", "answers", note=note)


def _answers(session: Session, study: Study, person: Person) -> Sequence[Answer]:
    wanted = select(Answer).where(Answer.study_id == study.id, Answer.person_id == person.id)
    return session.scalars(wanted.order_by(Answer.id)).all()


def _leave_out(session: Session, study: Study, answer: Answer) -> bool:
    if answer.excluded:
        return False
    program = _program(session)
    try:
        exclude(session, study, answer, program, REASON, again=True, now=now())
    except Refusal:  # nobody else is asked this
        exclude(session, study, answer, program, REASON, now=now())
    return True


def _was_left_out(session: Session, answer: Answer) -> bool:
    """Check that this program left an answer out, and that nobody has changed it since."""
    if not answer.excluded:
        return False
    wanted = select(Remark).where(Remark.answer_id == answer.id, Remark.kind != "commented")
    last = session.scalars(wanted.order_by(Remark.id.desc())).first()
    return last is not None and last.text == REASON


def _program(session: Session) -> Person:
    """Return the actor's name where the program leaves answers out."""
    wanted = select(Person).where(
        Person.provider == COMMAND_LINE, Person.external_hash == COMMAND_LINE
    )
    found = session.scalars(wanted).first()
    if found is None:
        found = Person(
            id=new_id(),
            role="worker",
            provider=COMMAND_LINE,
            external_hash=COMMAND_LINE,
            profile={},
            created_at=now(),
        )
        session.add(found)
        session.flush()
    return found
