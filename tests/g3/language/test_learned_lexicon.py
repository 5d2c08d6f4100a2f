"""A lexicon of words and labels, learned from what texts were about."""

import json
from math import log

import pytest

from g3.errors import FormatError
from g3.language.similarity import learned_lexicon, static_embeddings
from g3.language.similarity.learned_lexicon import (
    PSEUDO_COUNT,
    Lexicon,
    Naming,
    likeness,
    term_of,
    terms,
)

NAMINGS = (
    Naming(["take", "the", "red", "chair"], "generator", "yard"),
    Naming(["lift", "the", "chair"], "generator", "yard"),
    Naming(["lift", "the", "speaker"], "washing machine", "yard"),
    Naming(["grab", "the", "blue", "thing"], "washing machine", "yard"),
    Naming(["bring", "the", "parcel"], "boxes", "hall"),
)


@pytest.fixture
def without_likeness(monkeypatch):
    monkeypatch.setattr(learned_lexicon, "likeness", lambda words, name: 0.0)


def test_words_for_what_to_do_and_where_are_left_out():
    text = "Please pick up the left red chairs".lower().split()
    assert [term.form for term in terms(text)] == ["red", "chair", "red chair"]
    assert [term.place for term in terms(text)] == [5, 6, 5]


def test_log_odds_compare_what_was_seen_with_the_share_of_the_corpus(without_likeness):
    lexicon = Lexicon.learn(NAMINGS)
    chair = term_of("chairs")
    assert lexicon.count(chair) == 2
    # Seen twice with generators, half of the yard's texts: once is expected.
    seen, expected = 2 + PSEUDO_COUNT, 1 + PSEUDO_COUNT
    assert lexicon.log_odds(chair, "generator") == pytest.approx(log(seen / expected))
    never = log(PSEUDO_COUNT / expected)
    assert lexicon.log_odds(chair, "washing machine") == pytest.approx(never)
    assert lexicon.log_odds(chair, "boxes") == 0  # which nobody could choose there


def test_log_odds_do_not_depend_on_what_was_asked_before(monkeypatch):
    monkeypatch.setattr(
        learned_lexicon, "likeness", lambda words, name: 0.9 if words == "fridge" else 0.1
    )
    one, many = Lexicon.learn(NAMINGS), Lexicon.learn(NAMINGS)
    first = [one.log_odds(term_of(word), "generator") for word in ("fridge", "fridges")]
    second = [many.log_odds(term_of(word), "generator") for word in ("fridges", "fridge")]
    assert first == second[::-1]


def test_a_corpus_with_one_kind_of_thing_tells_nothing(without_likeness):
    lexicon = Lexicon.learn(NAMINGS)
    assert {lexicon.log_odds(term_of("parcel"), name) for name in lexicon.names} == {0.0}


def test_weights_count_as_parts_of_texts(without_likeness):
    half = [Naming(n.words, n.name, n.corpus, 0.5) for n in NAMINGS]
    twice = Lexicon.learn([*half, *half])
    once = Lexicon.learn(NAMINGS)
    for name in once.names:
        chair = term_of("chair")
        assert twice.log_odds(chair, name) == pytest.approx(once.log_odds(chair, name))


def test_an_unknown_word_means_what_it_is_like(monkeypatch):
    monkeypatch.setattr(static_embeddings, "find_spec", lambda _: None)
    likeness.cache_clear()
    try:
        lexicon = Lexicon.learn(NAMINGS)
        odds = {name: lexicon.log_odds(term_of("generators"), name) for name in lexicon.names}
        assert max(odds, key=odds.get) == "generator"
        assert likeness("zzyzx", "generator") == 0
    finally:
        likeness.cache_clear()


@pytest.mark.skipif(not static_embeddings.is_installed(), reason=static_embeddings.MISSING)
def test_embeddings_know_words_that_no_label_has():
    assert likeness("fridge", "refrigerator pallet") > 0.6
    assert likeness("elephant", "refrigerator pallet") < 0.3
    assert likeness("fridges", "refrigerator") == pytest.approx(likeness("fridge", "refrigerator"))
    assert likeness("tall boxes", "box") >= 0.99 * likeness("tall box", "box")
    lexicon = Lexicon.learn([Naming(["xyz"], "refrigerator"), Naming(["xyz"], "tire")])
    assert lexicon.log_odds(term_of("fridge"), "refrigerator") > 1
    assert lexicon.log_odds(term_of("fridge"), "tire") == 0


def test_files_give_the_same_back(tmp_path):
    lexicon = Lexicon.learn(NAMINGS)
    lexicon.save(tmp_path / "words.json")
    again = Lexicon.load(tmp_path / "words.json")
    assert again.corpora == lexicon.corpora
    again.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "words.json").read_bytes()


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (lambda own: own["corpora"]["yard"]["names"].update(generator=9.0), "digest"),
        (lambda own: own.update(schema_version=9), "version is 9"),
        (lambda own: own.pop("corpora"), "no lexicon"),
    ],
)
def test_damage_is_found(change, what, tmp_path):
    path = tmp_path / "words.json"
    Lexicon.learn(NAMINGS).save(path)
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))
    with pytest.raises(FormatError, match=what):
        Lexicon.load(path)
    with pytest.raises(FormatError, match="can't be read"):
        Lexicon.load(tmp_path / "missing.json")
