from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rapidfuzz.distance import OSA

from g3.language.lexicon.field_words import bare, field_words, figure_words, normalise
from g3.language.lexicon.spelling import mended
from g3.language.lexicon.tables import WORDS, members, written
from g3.language.lexicon.verb_chains import verb_of
from g3.language.lexicon.verb_classes import word_class
from g3.language.similarity.resources import wordnet
from g3.sdc.clauses import SDC, Span
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.language.installed import needs_wordnet


@pytest.mark.parametrize(
    ("word", "form"),
    [
        ("Pallets,", "pallet"),
        ("pallet", "pallet"),
        ("tires", "tire"),
        ('"Trailer"', "trailer"),
        ("boxes", "box"),
        ("(the", "the"),
        ("lifting", "lift"),
        ("left-hand", "left-hand"),
        ("...", ""),
        ("-", ""),
        ("2nd", "2nd"),
        ("Frthest", "furthest"),
        ("betwene", "between"),
    ],
)
def test_normalise(word: str, form: str) -> None:
    assert normalise(word) == form


KNOWN = sorted(
    word
    for word in WORDS["mended"].union(*map(written, members("class").values()))
    if word.isalpha()
)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("pikc", "pick"),
        ("drve", "drive"),
        ("lfit", "lift"),
        ("placng", "placing"),
        ("wiht", "with"),
        ("trcuk", "truck"),
        ("tyres", "tires"),
        ("cloesst", "closest"),
        # words of English are left, and so are names and what nothing is like
        ("closet", "closet"),
        ("tuck", "tuck"),
        ("conex", "conex"),
        ("genset", "genset"),
        ("kuka", "kuka"),
        ("ickup", "ickup"),
        ("teh", "teh"),
        ("truck-2", "truck-2"),
        ("x" * 5000, "x" * 5000),
    ],
)
def test_what_is_no_word_is_mended_if_it_is_one_slip_away(typed: str, meant: str) -> None:
    assert mended(typed) == meant


@given(st.sampled_from(KNOWN))
def test_words_that_decide_are_left_as_they_are(word: str) -> None:
    assert mended(word) == word


@given(st.text("abcdefghijklmnoprstuvwyz", max_size=9) | st.sampled_from(KNOWN), st.data())
def test_what_is_mended_begins_alike_is_one_slip_away_and_stays(word: str, data) -> None:
    at = data.draw(st.integers(1, max(1, len(word) - 1)))
    typed = word[:at] + data.draw(st.sampled_from(["", word[at - 1 : at], "e"])) + word[at + 1 :]
    meant = mended(typed)
    if meant != typed:
        assert meant[0] == typed[0]
        assert OSA.distance(typed, meant) == 1
        assert meant in WORDS["mended"] or word_class(meant)
        assert mended(meant) == meant


@needs_wordnet
def test_no_noun_is_taken_for_another_word() -> None:
    nouns = [noun for noun in wordnet().senses if noun.isalpha() and noun.isascii()]
    changed = {noun: mended(noun) for noun in nouns[::7] if mended(noun) != noun}
    assert len(changed) < 0.005 * len(nouns) / 7, changed


@given(st.text(max_size=8))
def test_normalise_does_not_see_capitals_or_punctuation_around(word: str) -> None:
    assert normalise(word.lower()) == normalise(f"({word.lower()},")


def spans(text: str) -> tuple[Span, ...]:
    return tuple(Span(10 * i, word) for i, word in enumerate(text.split()))


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("'em", "them"),
        ("em,", "them"),
        ("Teh", "the"),
        ("’re", "are"),
        ("'d", "would"),
        # A letter by itself may name a place.
        ("D", "d"),
        ("d", "d"),
        ("R", "right"),
        ("'d'", "d"),
        ("'s", "s"),
        ("don't", "don't"),
        ("crate's", "crate's"),
    ],
)
def test_words_are_written_out_but_for_names(typed: str, meant: str) -> None:
    assert bare(typed) == meant


def test_field_words_keep_their_order_and_drop_what_is_empty() -> None:
    assert field_words(spans("To the LEFT , of")) == ("to", "the", "left", "of")
    assert field_words(()) == ()


def figure(notation: str) -> tuple[str, ...]:
    (sdc,) = parse_brackets(notation)
    return figure_words(sdc)


@pytest.mark.parametrize(
    ("notation", "words"),
    [
        ("OBJ(f = the tire pallets)", ("the", "tire", "pallet")),
        # an inner clause's words are its figure's, not its landmark's
        (
            "OBJ(f = OBJ(f = the pallet), r = on, l = OBJ(f = the truck))",
            ("the", "pallet"),
        ),
        # unless the landmark tells what the figure is made of
        (
            "OBJ(f = OBJ(f = the pallet), r = of, l = OBJ(f = tires))",
            ("the", "pallet", "tire"),
        ),
        (
            "OBJ(f = OBJ(f = the trailer), r = carrying, l = OBJ(f = boxes))",
            ("the", "trailer"),
        ),
        (
            "OBJ(f = OBJ(f = the box), r = to the left of, l = OBJ(f = the truck))",
            ("the", "box"),
        ),
        # a clause in a clause
        (
            "OBJ(f = OBJ(f = OBJ(f = the box), r = on, l = OBJ(f = it)), r = by, l = OBJ(f = me))",
            ("the", "box", "on", "it"),
        ),
    ],
)
def test_figure_words(notation: str, words: tuple[str, ...]) -> None:
    assert figure(notation) == words


def test_words_stand_in_the_order_of_the_command() -> None:
    pallet, tires = SDC("OBJECT", words=spans("pallet")), SDC("OBJECT", words=(Span(90, "tires"),))
    two = SDC("OBJECT", relation=(Span(50, "of"),), figure=(pallet,), landmark1=(tires,))
    assert figure_words(two) == ("pallet", "tire")


def test_a_clause_without_a_figure_has_no_figure_words() -> None:
    assert figure_words(SDC("OBJECT")) == ()
    assert figure("PLACE(r = on, l = OBJ(f = the truck))") == ()


@pytest.mark.parametrize(
    ("participle", "wanted"),
    [
        ("placed", "placing"),
        ("laid", "placing"),
        ("taken", "taking"),
        ("brought", "carrying"),
        ("driven", "going"),
        ("held", "staying"),
    ],
)
def test_a_passive_asks_for_what_its_verb_asks_for(participle: str, wanted: str) -> None:
    assert wanted in verb_of(("shall", "be", participle)).classes
    assert wanted in verb_of(("is", "to", "be", participle)).classes


def test_a_participle_before_a_noun_asks_for_nothing() -> None:
    assert not verb_of(("held",)).classes
    assert verb_of(("hold",)).classes == {"staying", "taking"}
