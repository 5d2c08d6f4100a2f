"""What spaCy is given, and what comes back."""

from __future__ import annotations

import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.errors import ModelError
from g3.language.parsing.mending import FREQUENT, mend, mend_unknown
from g3.language.parsing.spacy_pipeline import VARIABLE, _cut, analyse, language_model


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


def test_a_letter_before_a_full_stop_is_no_abbreviation():
    (command,) = analyse(["Go to truck A. Wait."])
    assert command.lower == ("go", "to", "truck", "a", ".", "wait", ".")


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


def test_words_that_nobody_knows_are_mended_where_that_is_plain():
    (command,) = analyse(["Plcae it bewteen teh canters and the xyzzy, NEXXT to a tire"])
    assert command.lower == (
        "place", "it", "between", "teh", "canters", "and", "the", "xyzzy", ",", "next", "to", "a",
        "tire",
    )  # fmt: skip
    assert [span.text for span in command.spans][:3] == ["Plcae", "it", "bewteen"]


@given(st.text(max_size=12))
def test_only_letters_are_mended_and_known_words_stay(word):
    mended = mend_unknown(word, frozenset())
    assert mended == word or mended in FREQUENT
    assert mend_unknown(mended, frozenset()) == mended
    assert mend_unknown(word, {word}) == word


def test_a_word_is_read_alike_however_often_it_was_read():
    first, again = (next(analyse(["put it bewteen them"])).lower for _ in range(2))
    language_model().vocab.strings.add("bewteen")
    _cut.cache_clear()
    assert first == again == next(analyse(["put it bewteen them"])).lower


def test_capitals_are_cut_as_small_letters_are():
    for text in ("DON'T LIFT IT, I'M GONNA", "CAN'T"):
        one, other = analyse([text, text.lower()])
        assert one.lower == other.lower


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
