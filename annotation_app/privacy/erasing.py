"""Finding the person that somebody asks to have erased, and erasing them for good."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import ColumnElement, Engine, or_, select
from sqlalchemy.orm import Session

from annotation_app.core.config import Config
from annotation_app.core.person_codes import read_code
from annotation_app.people.participants import hashed
from annotation_app.privacy.erasure import Traces, erase, traces_of
from annotation_app.store import tombstones
from annotation_app.store.audit import COMMAND_LINE, SUBJECT_CHARACTERS, note
from annotation_app.store.compaction import compact_if_asked
from annotation_app.store.database import transaction
from annotation_app.store.models import Erasure, Person
from annotation_app.store.salt import installation_salt
from annotation_app.store.schema import check_current
from annotation_app.store.tombstones import ERASED_FILE
from g3.errors import FormatError

_SUBJECT = re.compile(rf"[0-9a-f]{{{SUBJECT_CHARACTERS},64}}")


@dataclass(frozen=True, slots=True)
class Done:
    """What was erased.

    Parameters
    ----------
    tombstones
        The file in which it was noted.
    is_compacted
        Whether the database's files hold nothing of it any more.
    """

    traces: Traces
    tombstones: Path
    is_compacted: bool


def preview(engine: Engine, config: Config, who: str, platform: str | None) -> Traces:
    """What there is of a person.

    Parameters
    ----------
    who
        Their code, what exports call them, or their login; with a platform, their id there.

    Raises
    ------
    FormatError
        If nobody is meant, or several people.
    """
    check_current(engine)
    wanted = _wanted(who)
    if platform is not None:
        digest = hashed(installation_salt(engine, config), platform, who)
        wanted = (Person.provider == platform) & (Person.external_hash == digest)
    with transaction(engine) as session:
        people = session.scalars(
            select(Person).where(wanted, Person.id.not_in(select(Erasure.person_id))).limit(2)
        ).all()
        if len(people) != 1:
            raise FormatError(
                "several people are meant" if people else "there is no such person",
                where=who[:100],
                fix="give the code that their pages show, what exports call them, or a login; "
                "for a worker's id at a platform give --platform too",
            )
        return traces_of(session, people[0])


def erase_person(engine: Engine, config: Config, person_id: str, *, now: float) -> Done:
    """Erase a person's data from the database and its files, and note that it was done.

    The audit trail names the random id by which the database knew them, which nothing leads to
    any more, and how much was erased.
    """
    with transaction(engine) as session:
        traces = erase(session, _person(session, person_id), now=now)
        note(session, COMMAND_LINE, "erased a person's data", person_id, **traces.counts())
    tombstones.keep(engine, config.instance)
    return Done(traces, config.instance / ERASED_FILE, compact_if_asked(engine))


def _person(session: Session, person_id: str) -> Person:
    return session.get_one(Person, person_id, with_for_update=True)


def _wanted(who: str) -> ColumnElement[bool]:
    given = who.strip()
    meant = [Person.login == given.casefold()]
    code = read_code(given)
    if code is not None:
        meant.append(Person.code == code)
    if _SUBJECT.fullmatch(given.lower()):
        meant.append(Person.external_hash.startswith(given.lower(), autoescape=True))
    return or_(*meant)
