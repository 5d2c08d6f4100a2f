"""What spaCy is given, and what comes back."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from g3.errors import ModelError
from g3.language.parsing.mending import mend
from g3.language.parsing.spacy_pipeline import VARIABLE, analyse, language_model


def test_words_stand_where_they_were_typed():
    text = "  Put the Tyre-palette\ton it. Go!"
    (command,) = analyse([text])
    assert [span.text for span in command.spans] == [
        "Put", "the", "Tyre", "-", "palette", "on", "it", ".", "Go", "!",
    ]  # fmt: skip
    assert all(text[span.start : span.end] == span.text for span in command.spans)
    assert command.lower[2:5] == ("tire", "-", "pallet")


@pytest.mark.parametrize(
    "text", ["Lower forks.", "position it", "Go left. Back up.", "lift pallet"]
)
def test_imperatives_are_read_as_verbs(text):
    (command,) = analyse([text])
    strings = language_model().vocab.strings
    begins = [0, *(i + 1 for i, word in enumerate(command.lower[:-1]) if word == ".")]
    assert {strings[int(command.tag[i])] for i in begins} == {"VB"}


@pytest.mark.parametrize("text", ["tires go on the truck", "Stop. Gensets to the left"])
def test_nouns_are_not_read_as_verbs(text):
    (command,) = analyse([text])
    strings = language_model().vocab.strings
    noun = command.lower.index("tires" if "tires" in text else "gensets")
    assert strings[int(command.tag[noun])].startswith("NN")


def test_short_forms_are_read_as_what_they_stand_for_and_asides_left_out():
    text = "u put 'em thru lol n lift ur crate pls"
    (command,) = analyse([text])
    assert command.lower == ("you", "put", "them", "through", "and", "lift", "your", "crate")
    assert [span.text for span in command.spans][:4] == ["u", "put", "'em", "thru"]
    assert all(text[span.start : span.end] == span.text for span in command.spans)


@pytest.mark.parametrize(
    "text", ["No need to lift it", "There's no need to lift it", "there is no need to lift it"]
)
def test_no_need_is_read_as_a_negation(text):
    (found,) = analyse([text])
    assert found.lower == ("do", "n't", "lift", "it")
    assert "".join(span.text for span in found.spans).lower() == "noneedliftit"
    (other,) = analyse(["Lift it with no need for a truck"])
    assert other.lower[2:6] == ("with", "no", "need", "for")


def test_a_letter_before_a_full_stop_is_no_abbreviation():
    (command,) = analyse(["Go to truck A. Wait."])
    assert command.lower == ("go", "to", "truck", "a", ".", "wait", ".")


STEPS = ("go to crate 7", "lift it", "pick up pallet 2", "put it on truck 1", "wait 2 seconds")


@given(
    steps=st.lists(st.sampled_from(STEPS), min_size=1, max_size=4),
    number=st.sampled_from(["{}. ", "{}) ", "Step {}: ", "step {}. "]),
    between=st.sampled_from(["\n", " ", "\n\n"]),
)
@example(steps=["lift it", "wait", "lift pallet 2", "go"], number="{}. ", between="\n")
@settings(deadline=None, max_examples=40)
def test_numbered_steps_are_read_as_sentences(steps, number, between):
    listed = [number.format(i) + step for i, step in enumerate(steps, start=1)]
    plain, command = analyse([". ".join(steps), text := between.join(listed)])
    assert command.lower == plain.lower
    assert all(text[span.start : span.end] == span.text for span in command.spans)
    assert [s.text for s in command.spans if s.text.isalpha()] == [
        s.text for s in plain.spans if s.text.isalpha()
    ]


def test_a_number_that_ends_a_step_is_not_the_next_ones():
    (command,) = analyse(["1. Lift pallet 2. 2. Put it down."])
    assert command.lower == ("lift", "pallet", "2", ".", ".", "put", "it", "down", ".")


@pytest.mark.parametrize("text", ["pick up pallet 2. lift it", "go to 1) and 2)", "2. lift it"])
def test_other_numbers_are_words(text):
    (command,) = analyse([text])
    assert [word for word in command.lower if word.isdigit()] == re.findall(r"\d", text)


def test_heads_are_words_of_the_command():
    for command in analyse(["Lift it. Go to the truck on the left", "", "the crate"]):
        assert all(0 <= head < len(command.spans) for head in command.head)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("palllet", "pallet"),
        ("trialer", "trailer"),
        ("tailor", "trailer"),
        ("foward", "forward"),
        ("trailers", "trailers"),
        ("lift", "lift"),
        ("light", "light"),
        ("x" * 5000, "x" * 5000),
    ],
)
def test_misspellings(typed, meant):
    assert mend(typed) == meant


def test_a_model_that_is_not_there_is_told(monkeypatch):
    monkeypatch.setenv(VARIABLE, "no_such_model")
    language_model.cache_clear()
    try:
        with pytest.raises(ModelError, match="no_such_model"):
            language_model()
    finally:
        language_model.cache_clear()


def test_importing_the_package_imports_neither_spacy_nor_numba():
    code = (
        "import sys, g3, g3.features, corpus_tools.cli.console;"
        "sys.exit(bool({'spacy', 'numba'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_spacy_comes_without_its_command_line_which_can_be_imported_later():
    check = (
        "import sys\n"
        "from g3.language.parsing.spacy_import import import_spacy\n"
        "spacy = import_spacy()\n"
        "assert import_spacy() is spacy and 'spacy.cli' not in sys.modules\n"
        "import spacy.cli\n"
        "assert callable(spacy.cli.download)\n"
        "assert spacy.info(silent=True)['spacy_version'] == spacy.__version__\n"
    )
    subprocess.run([sys.executable, "-c", check], check=True)
