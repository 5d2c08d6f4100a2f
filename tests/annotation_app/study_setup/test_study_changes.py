"""What a changed file alters of what people were asked."""

from __future__ import annotations

from msgspec.structs import replace

from annotation_app.studies.study_file import StudyConfig, TaskConfig
from annotation_app.study_setup.study_changes import Asked, changes

BEFORE = StudyConfig(
    name="arm",
    title="An arm",
    robot="arm",
    tasks={"describe": TaskConfig(), "rate": TaskConfig(answers=2)},
)
ASKED = Asked({"describe": 3, "rate": 1}, people=2)
NOBODY = Asked({}, people=0)


def altered(
    after: StudyConfig, asked: Asked = ASKED, before: StudyConfig = BEFORE
) -> dict[str, str]:
    return {change.field: change.alters for change in changes(before, after, asked)}


def test_titles_and_numbers_alter_nothing() -> None:
    more = {**BEFORE.tasks, "rate": TaskConfig(answers=5)}
    assert altered(replace(BEFORE, title="The arm", tasks=more)) == {
        "title": "",
        "tasks.rate.answers": "",
    }
    assert altered(BEFORE) == {}


def test_words_alter_the_answers_of_their_task() -> None:
    words = {**BEFORE.tasks, "describe": TaskConfig(instructions="Type.")}
    told = {"tasks.describe.instructions": "3 answers to describe came before"}
    assert altered(replace(BEFORE, tasks=words)) == told
    assert altered(replace(BEFORE, statement="It does.")) == {
        "statement": "1 answer to rate came before"
    }
    assert altered(replace(BEFORE, statement="It does."), NOBODY) == {"statement": ""}


def test_what_may_be_drawn_alters_the_answers() -> None:
    before = replace(BEFORE, tasks={"ground": TaskConfig()})
    after = replace(BEFORE, tasks={"ground": TaskConfig(drawing=True)})
    told = {"tasks.ground.drawing": "2 answers to ground came before"}
    assert altered(after, Asked({"ground": 2}, people=0), before) == told


def test_the_robots_name_is_in_the_statement_and_the_consent() -> None:
    before = replace(BEFORE, consent="You see a {robot}.")
    told = {"robot": "2 people have agreed to the old one; 1 answer to rate came before"}
    assert altered(replace(before, robot="hand"), before=before) == told
    assert altered(replace(BEFORE, robot="hand")) == {"robot": "1 answer to rate came before"}


def test_another_language_alters_all_that_people_read() -> None:
    assert altered(replace(BEFORE, locale="de")) == {
        "locale": "2 people have agreed to the old one; 3 answers to describe came before; "
        "1 answer to rate came before"
    }


def test_a_task_that_is_left_out_is_named() -> None:
    found = altered(replace(BEFORE, tasks={"describe": TaskConfig()}))
    assert found["tasks.rate.answers"] == "1 answer to rate came before"


def test_both_are_shown_as_text() -> None:
    (change,) = changes(BEFORE, replace(BEFORE, scale=("a", "b", "c", "d", "e")), NOBODY)
    assert (change.after, change.before.splitlines()[0]) == ("a\nb\nc\nd\ne", "Strongly disagree")
