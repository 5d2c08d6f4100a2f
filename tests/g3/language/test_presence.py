"""Whether nouns name what there is, with and without embeddings."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.language.similarity import presence, static_embeddings
from g3.language.similarity.learned_lexicon import Lexicon, Naming
from g3.language.similarity.presence import best_naming, least_alike, may_be_absent
from g3.language.similarity.resources import wordnet
from g3.language.similarity.wordnet import share_of_senses

THINGS = (
    ("tire", "pallet"),
    ("box", "pallet"),
    ("person",),
    ("truck",),
    ("shelf",),
    ("cone",),
    ("storage A",),
)
ANIMALS = re.findall(
    r"\w+",
    "elephant giraffe zebra kangaroo penguin crocodile lion tiger rabbit horse cow dog cat "
    "sheep goat frog snake whale shark spider hamster squirrel deer camel parrot wolf fox",
)
GENERIC_NOUNS = re.findall(r"\w+", "thing things object load goods one it area side them something")
LABELS = [
    ("tire", "assembly", "pallet"),
    ("generator", "accessories", "pallet"),
    ("washing", "machine", "pallet"),
    ("semi", "truck"),
    ("ship", "container"),
    ("sign", "post"),
    ("berm",),
    ("drum",),
    ("refrigerator", "pallet"),
    *THINGS,
]


@pytest.fixture(params=[True, False], ids=["embeddings", "wordnet"])
def embeddings(request, monkeypatch):
    """With embeddings, where they are installed, and without."""
    if request.param and not static_embeddings.is_installed():
        pytest.skip("the extra embeddings isn't installed")
    if not request.param:
        monkeypatch.setattr(static_embeddings, "is_installed", lambda: False)
    presence._likeness.cache_clear()
    yield
    presence._likeness.cache_clear()


def is_absent(noun, things, lexicon=None):
    return may_be_absent(noun) and best_naming(noun, things, lexicon) < least_alike()


@pytest.mark.parametrize("animal", ANIMALS)
def test_animals_are_seen_to_be_absent(animal, embeddings):
    assert share_of_senses(wordnet(), animal, ("animal",)) > 0
    assert is_absent(animal, THINGS)


@given(st.lists(st.sampled_from(LABELS), min_size=1, max_size=6), st.data())
def test_a_label_of_what_is_there_is_never_absent(things, data):
    labels = data.draw(st.sampled_from(things))
    noun = data.draw(st.sampled_from(" ".join(labels).lower().split()))
    for form in (noun, f"{noun}s"):
        assert not is_absent(form, things)


@given(st.sampled_from(GENERIC_NOUNS))
def test_generic_nouns_are_never_absent(noun):
    assert not is_absent(noun, ())


@pytest.mark.parametrize(
    "noun", ["lorry", "vehicle", "tyres", "man", "worker", "palet", "skid", "degrees"]
)
def test_other_words_for_what_is_there_are_not_absent(noun, embeddings):
    assert not is_absent(noun, (*THINGS, ("forklift",)))


def test_a_learned_word_is_not_absent():
    things = (("washing", "machine", "pallet"),)
    assert is_absent("speaker", things)
    other = [Naming(["the", "tires"], "tire pallet")] * 3
    learned = [Naming(["the", "speaker"], "washing machine pallet")] * 3
    assert not is_absent("speaker", things, Lexicon.learn([*learned, *other]))
    assert is_absent("speaker", (("tire", "pallet"),), Lexicon.learn([*learned, *other]))


def test_nothing_is_named_where_nothing_is():
    assert best_naming("truck", ()) == 0
