"""Giving people work: permission for a study's tasks, and the next item."""

from __future__ import annotations

from typing import Literal, TypeAlias

from sqlalchemy import bindparam, select
from sqlalchemy.orm import Session

from annotation_app.core.languages import N_, gettext, speak
from annotation_app.core.problems import Refusal
from annotation_app.items import assignment
from annotation_app.items.assignment import Lease, Work
from annotation_app.people.browser_sessions import current_id, current_number, required_person
from annotation_app.people.participants import OPEN, RANKS, has_consented, has_practised
from annotation_app.store.models import Person, Study, TaskName
from annotation_app.studies.study_file import StudyConfig, TaskConfig, language_of, restored
from annotation_app.tasks.task_registry import task_of

Reason: TypeAlias = (
    assignment.Reason
    | Literal["closed", "not part", "not invited", "no consent", "no practice", "role"]
)

EXPLANATIONS: dict[Reason, str] = {
    "done": N_("You have done all that there is for you here. Thank you!"),
    "blocked": N_(
        "You can't take part any more. Write to the people who run the study if you "
        "think that this is a mistake."
    ),
    "all taken": N_(
        "Others are at work on all that is left. Some of it may become free: try again "
        "in a few minutes."
    ),
    "nothing to do": N_("There is nothing to do here at the moment."),
    "closed": N_("The study is closed. Thank you for your interest!"),
    "not part": N_("This task is not part of the study."),
    "not invited": N_("Only people who have been invited can take part in this study."),
    "no consent": N_("Please read what the study is about, and agree to it, first."),
    "no practice": N_("Please do the practice example first."),
    "role": N_("This task is for annotators, who have a login."),
}
"""Texts for people who get no item, by reason."""
HOLD_S = 120.0
"""Duration of a lease whose holder has opened the page and done nothing, in seconds."""


_STUDY = select(Study).where(Study.name == bindparam("study"))
_VISIT = _STUDY.add_columns(Person).join(
    Person, (Person.id == bindparam("who")) & (Person.session_number == bindparam("number"))
)


def visit(session: Session, study_name: str) -> tuple[Person | None, Study]:
    """Return the request's person and study; refuse if there is no such study."""
    whose = {"who": current_id(), "number": current_number()}
    row = session.execute(_VISIT, {**whose, "study": study_name}).first()
    person, study = (None, find_study(session, study_name)) if row is None else (row[1], row[0])
    speak(language_of(study.config))
    return person, study


def find_study(session: Session, name: str) -> Study:
    """Return a study by its name; refuse if there is none."""
    study = session.scalars(_STUDY, {"study": name}).first()
    if study is None:
        raise Refusal(404, gettext("There is no such study."))
    return study


def task_config(config: StudyConfig, task: TaskName) -> TaskConfig:
    """Return a task's settings in a study, defaults for one that has been taken out of it."""
    return config.tasks.get(task, TaskConfig())


def obstacle(study: Study, config: StudyConfig, task: TaskName, person: Person) -> Reason | None:
    """Return the reason that bars a person from a study's task, regardless of its items."""
    asked = config.tasks.get(task)
    is_staff = RANKS[person.role] > RANKS["worker"]
    checks: tuple[tuple[bool, Reason], ...] = (
        (person.blocked_at is not None, "blocked"),
        (study.closed_at is not None, "closed"),
        (asked is None, "not part"),
        (config.access == "invited" and person.provider == OPEN and not is_staff, "not invited"),
        (asked is not None and RANKS[person.role] < RANKS[asked.role], "role"),
        (not has_consented(person, study.id), "no consent"),
        (must_practise(config, task, person), "no practice"),
    )
    return next((reason for fails, reason in checks if fails), None)


def must_practise(config: StudyConfig, task: TaskName, person: Person) -> bool:
    """Check that a person has to do a task's practice example first."""
    asked = config.tasks.get(task)
    has_example = task_of(task).example is not None
    return asked is not None and asked.practice and has_example and not has_practised(person, task)


def take_work(
    session: Session,
    study: Study,
    task: TaskName,
    person: Person,
    *,
    now: float,
    hold_s: float | None = None,
) -> Lease | Reason:
    """Give somebody an item of a task, or say why not.

    They have it for `hold_s` if they do nothing, else as long as the study says.
    """
    config = restored(study.config)
    reason = obstacle(study, config, task, person)
    if reason is not None:
        return reason
    of_task = task_of(task)
    return assignment.take(
        session,
        study.id,
        task,
        person,
        now=now,
        lease_s=lease_s(config, task),
        hold_s=hold_s,
        attention_share=config.attention_checks if of_task.passes is not None else 0.0,
        in_random_order=of_task.in_random_order,
    )


def lease_s(config: StudyConfig, task: TaskName) -> float:
    """Return the duration of a lease of a task's item, in seconds."""
    return 60 * task_config(config, task).lease_minutes


def item_of(session: Session, item_id: str) -> Work:
    """Return an item that is or was the requesting person's; refuse if it never was."""
    found = assignment.handed_out(session, item_id, current_id() or "", current_number())
    if found is None:
        required_person(session)
        raise Refusal(404, gettext("You don't have such an item. Open the study again."))
    speak(language_of(found.config))
    return found
