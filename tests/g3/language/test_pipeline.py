"""What spaCy is given, and what comes back."""

from __future__ import annotations

import subprocess
import sys

import pytest

from g3.errors import ModelError
from g3.language.parsing.spacy_pipeline import VARIABLE, analyse, language_model


def test_words_stand_where_they_were_typed():
    text = "  Put the Tyre-palette\ton it. Go!"
    (command,) = analyse([text])
    assert [span.text for span in command.spans] == [
        "Put", "the", "Tyre", "-", "palette", "on", "it", ".", "Go", "!",
    ]  # fmt: skip
    assert all(text[span.start : span.end] == span.text for span in command.spans)
    assert command.lower[2:5] == ("tyre", "-", "palette")


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


def test_a_letter_before_a_full_stop_is_no_abbreviation():
    (command,) = analyse(["Go to truck A. Wait."])
    assert command.lower == ("go", "to", "truck", "a", ".", "wait", ".")


def test_heads_are_words_of_the_command():
    for command in analyse(["Lift it. Go to the truck on the left", "", "the crate"]):
        assert all(0 <= head < len(command.spans) for head in command.head)


def test_a_model_that_is_not_there_is_told(monkeypatch):
    monkeypatch.setenv(VARIABLE, "no_such_model")
    language_model.cache_clear()
    try:
        with pytest.raises(ModelError, match="no_such_model"):
            language_model()
    finally:
        language_model.cache_clear()


def test_importing_the_package_imports_no_spacy():
    code = "import sys, g3, g3.features, corpus_tools.cli.console;sys.exit('spacy' in sys.modules)"
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
