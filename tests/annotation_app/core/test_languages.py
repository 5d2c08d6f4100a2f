"""The catalogues: nothing is missing, stale or empty, and values have their places."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from babel.messages.catalog import Catalog, Message
from babel.messages.frontend import CommandLineInterface
from babel.messages.pofile import read_po

from annotation_app.core import languages
from annotation_app.core.languages import catalogue, gettext, ngettext, speaking, spoken
from annotation_app.tasks.practice_example import practice_example
from annotation_app.tasks.task_registry import tasks
from annotation_app.tasks.task_texts import task_words
from tests.annotation_app.pseudo import write_pseudo

ROOT = Path(__file__).resolve().parents[3]
VALUE = re.compile(r"%\(\w+\)s|\{\w+\}")


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Catalog:
    """What there is to translate, by the command of docs/how-to/translate.md."""
    file = tmp_path_factory.mktemp("texts") / "messages.pot"
    settings = ("-F", str(ROOT / "pyproject.toml"), "-c", "Translators:", "-o", str(file))
    CommandLineInterface().run(
        ["pybabel", "-q", "extract", *settings, str(ROOT / "annotation_app")]
    )
    with file.open("rb") as stream:
        return read_po(stream)


def strings(message: Message) -> list[str]:
    return [message.string] if isinstance(message.string, str) else list(message.string)


@pytest.mark.parametrize("language", languages.languages()[1:])
def test_all_that_there_is_to_say_can_be_said(template: Catalog, language: str) -> None:
    found = catalogue(language)
    wanted, there = ({message.id for message in one} - {""} for one in (template, found))
    assert wanted - there == set(), "run the commands of docs/how-to/translate.md"
    assert there - wanted == set(), "run the commands of docs/how-to/translate.md"
    assert not found.obsolete
    messages = [message for message in found if message.id]
    assert [m.id for m in messages if m.fuzzy or not all(strings(m))] == []
    files = {m.id: {Path(file).name for file, _ in m.locations} for m in template}
    there_in = {m.id: {Path(file).name for file, _ in m.locations} for m in messages}
    assert [m.id for m in messages if there_in[m.id] != files[m.id]] == []


@pytest.mark.parametrize("language", languages.languages()[1:])
def test_each_text_has_the_values_of_the_english_one(language: str) -> None:
    for message in catalogue(language):
        ids = [message.id] if isinstance(message.id, str) else list(message.id)
        wanted = set(VALUE.findall(ids[-1]))
        for text in strings(message) if message.id else ():
            assert set(VALUE.findall(text)) == wanted, message.id


def test_there_is_german() -> None:
    assert languages.languages() == ("en", "de")
    with speaking("de"):
        assert gettext("Send") == "Senden"
        assert gettext("You get %(amount)s for each item.", amount="0,05 EUR") == (
            "Sie bekommen 0,05 EUR für jede Aufgabe."
        )
        assert gettext("What nobody has translated") == "What nobody has translated"
        one = "There were too many wrong passwords. Try again in %(num)s minute."
        many = "There were too many wrong passwords. Try again in %(num)s minutes."
        assert ngettext(one, many, 1).endswith("in 1 Minute noch einmal.")
        assert ngettext(one, many, 2).endswith("in 2 Minuten noch einmal.")
    assert gettext("Send") == "Send"


def test_nobody_speaks_a_language_without_a_catalogue() -> None:
    with speaking("tlh"):
        assert str(spoken()) == "en"


def test_the_words_of_all_tasks_are_translated() -> None:
    for task in tasks():
        with speaking("de"):
            said = task_words(None, task)
        assert said.title != task.words.title
        assert not set(said.instructions) & set(task.words.instructions)


def test_people_practise_with_a_sentence_in_their_language() -> None:
    english = practice_example()
    with speaking("de"):
        german = practice_example()
    assert german.command == "Segle zu der Boje bei dem Leuchtturm."
    assert [clause["phrase"] for clause in german.clauses] == [
        "Segle zu der Boje bei dem Leuchtturm",
        "zu der Boje bei dem Leuchtturm",
        "der Boje bei dem Leuchtturm",
        "der Boje",
        "dem Leuchtturm",
    ]
    assert [c["node"] for c in german.clauses] == [c["node"] for c in english.clauses]
    assert all(german.command[word["start"] :].startswith(word["text"]) for word in german.words)
    assert german.scene == english.scene


def test_a_sentence_with_other_words_stays_english(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_pseudo(tmp_path)
    file = tmp_path / "ar" / languages.FILE
    text = file.read_text()
    start = text.index("msgstr", text.index('msgid "Sail to the buoy'))
    file.write_text(f'{text[:start]}msgstr "ابحر"{text[text.index(chr(10), start) :]}')
    monkeypatch.setattr(languages, "FOLDER", tmp_path)
    with speaking("ar"):
        assert gettext("Sail to the buoy by the lighthouse.") == "ابحر"
        assert practice_example().command == "Sail to the buoy by the lighthouse."
