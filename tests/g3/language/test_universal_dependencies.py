"""Commands as Universal Dependencies: trees worked by hand, and what the validator asks."""

from __future__ import annotations

from io import StringIO

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

pytest.importorskip("spacy", reason="the extra `language` is not installed")

from g3.language.parsing.conllu import to_conllu
from g3.language.parsing.spacy_pipeline import analyse
from g3.language.parsing.universal_dependencies import universal_words


def tree(text: str) -> dict[str, tuple[str, str]]:
    """For each word the word that it depends on ("" for the root) and how."""
    (analysis,) = analyse([text])
    words = [span.text for span in analysis.spans]
    return {
        word: ("" if u.head is None else words[u.head], u.relation)
        for word, u in zip(words, universal_words(analysis), strict=True)
    }


def test_prepositions_are_case_of_what_they_are_about():
    found = tree("Put a pallet on the truck")
    assert found == {
        "Put": ("", "root"),
        "a": ("pallet", "det"),
        "pallet": ("Put", "obj"),
        "on": ("truck", "case"),
        "the": ("truck", "det"),
        "truck": ("Put", "obl"),
    }


def test_two_prepositions_are_both_case():
    found = tree("Take the boxes out of that trailer")
    assert found["out"] == found["of"] == ("trailer", "case")
    assert found["trailer"] == ("Take", "obl")


def test_a_noun_after_a_noun_is_nmod():
    found = tree("Go to the left of the truck")
    assert found["left"] == ("Go", "obl")
    assert found["truck"] == ("left", "nmod")
    assert found["of"] == ("truck", "case")


def test_is_is_cop_of_what_something_is_and_of_where_it_is():
    found = tree("Lift the crate which is red")
    assert found["is"] == ("red", "cop")
    assert found["red"] == ("crate", "acl:relcl")
    assert found["which"] == ("red", "nsubj")
    found = tree("Lift the crate that is on a truck")
    assert found["is"] == ("truck", "cop")
    assert found["truck"] == ("crate", "acl:relcl")


def test_what_there_is_is_the_subject():
    found = tree("There is a crate")
    assert found == {
        "There": ("is", "expl"),
        "is": ("", "root"),
        "a": ("crate", "det"),
        "crate": ("is", "nsubj"),
    }


def test_conjuncts_depend_on_the_first_and_conjunctions_on_their_own():
    found = tree("Lift tires, boxes and crates")
    assert found["boxes"] == found["crates"] == ("tires", "conj")
    assert found["and"] == ("crates", "cc")
    assert found[","] == ("boxes", "punct")


def test_a_clause_after_a_preposition_has_a_mark():
    found = tree("Stop after passing the truck")
    assert found["after"] == ("passing", "mark")
    assert found["passing"] == ("Stop", "advcl")


def test_names_that_differ():
    found = tree("Pick up a crate to lift it")
    assert found["up"] == ("Pick", "compound:prt")
    assert found["to"] == ("lift", "mark")
    assert tree("Give me the truck's box") | {"Give": ("", "root")} == {
        "Give": ("", "root"),
        "me": ("Give", "iobj"),
        "the": ("truck", "det"),
        "truck": ("box", "nmod:poss"),
        "'s": ("truck", "case"),
        "box": ("Give", "obj"),
    }


def test_parts_of_speech_fit_their_relations():
    (analysis,) = analyse(["Lift a few boxes where they are"])
    found = {
        span.text: (word.upos, word.relation)
        for span, word in zip(analysis.spans, universal_words(analysis), strict=True)
    }
    assert found["few"] == ("ADJ", "amod")
    assert found["where"] == ("ADV", "advmod")


def test_several_sentences_are_one_tree():
    found = tree("Lift it. Drive on.")
    assert found["Lift"] == ("", "root")
    assert found["Drive"] == ("Lift", "parataxis")


def test_lemmas_and_parts_of_speech():
    (analysis,) = analyse(["Put both boxes behind it"])
    found = [(word.lemma, word.upos) for word in universal_words(analysis)]
    assert found == [
        ("put", "VERB"), ("both", "DET"), ("box", "NOUN"), ("behind", "ADP"), ("it", "PRON"),
    ]  # fmt: skip


TEXTS = st.text(
    st.one_of(st.sampled_from(" .,abc!?'\u0301é\u00a0\u2028\tÅ"), st.characters()), max_size=60
)


@pytest.fixture(scope="module")
def validator():
    """The official validator at its level 2; to make one takes a quarter of a second."""
    udtools = pytest.importorskip("udtools", reason="udtools is not installed")
    return udtools.Validator(lang="en", level=2)


@settings(max_examples=60, deadline=None)
@example("A\u030a e\u0301 .")
@example("of of of to")
@given(st.lists(TEXTS, min_size=1, max_size=5))
def test_any_text_is_valid_at_level_2(validator, texts):
    """The validator finds nothing, whatever people type."""
    parts = [
        to_conllu(analysis, (), sent_id=f"a/{number}")
        for number, analysis in enumerate(analyse(texts))
    ]
    content = "".join(f"{part}\n" for part in parts if part)
    if content:
        state = validator.validate_file_handle(StringIO(content))
        assert state.passed(), str(state)
