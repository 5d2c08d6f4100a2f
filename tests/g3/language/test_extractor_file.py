"""Extractors as bytes."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest

from g3.array_file import DIGEST, write_arrays
from g3.errors import CorpusError, ModelError
from g3.language.extractor import Extractor
from g3.language.extractor_file import default_extractor, from_bytes, to_bytes
from g3.language.extractor_training import DEFAULT_L2, prepare, recipe, train_extractor
from g3.language.parser import parse
from g3.sdc_notation import parse_brackets

TAUGHT = {
    "Lift the crate on the truck": (
        "EVENT(r = Lift, l = OBJ(f = OBJ(f = the crate), r = on, l = OBJ(f = the truck)))"
    ),
    "Go left": "EVENT(r = Go left)",
    "Put it on the truck": (
        "EVENT(r = Put, l = OBJ(f = it), l2 = PLACE(r = on, l = OBJ(f = the truck)))"
    ),
}


def lessons():
    return prepare([(text, parse_brackets(tree, command=text)) for text, tree in TAUGHT.items()])


@pytest.fixture(scope="module")
def extractor():
    return train_extractor(lessons(), card={"scenarios": ["a"]})


def test_bytes_and_back(extractor):
    content = to_bytes(extractor)
    again = from_bytes(content)
    assert to_bytes(again) == content
    assert again.card == {"scenarios": ["a"], "recipe": recipe()}
    for text, tree in TAUGHT.items():
        one, other = parse(text, extractor=extractor), parse(text, extractor=again)
        assert one.sdcs == other.sdcs == parse_brackets(tree, command=text)


def test_training_is_deterministic(extractor):
    assert to_bytes(train_extractor(lessons(), card={"scenarios": ["a"]})) == to_bytes(extractor)


def test_nothing_to_learn_from():
    with pytest.raises(CorpusError, match="no commands with annotated SDC trees"):
        train_extractor(prepare([("", ())]))


def changed(content, *, sealed=True, **arrays):
    """An extractor with other arrays, whose digest is right."""
    with np.load(io.BytesIO(content)) as file:
        found = {name: file[name] for name in file.files if name != DIGEST} | arrays
    return write_arrays(
        {n: array for n, array in found.items() if array is not None}, sealed=sealed
    )


@pytest.mark.parametrize(
    "arrays",
    [
        {"role_weights": np.zeros((3, 3))},
        {"role_keys": None},
        {"form": np.frombuffer(b"{}", dtype=np.uint8)},
        {"card": np.frombuffer(b"nothing", dtype=np.uint8)},
        {"attachment_weights": np.zeros((1, 1))},
    ],
)
def test_damaged_files_are_refused(extractor, arrays):
    with pytest.raises(ModelError, match=r"model: .*(can't be read|is missing|has the type)"):
        from_bytes(changed(to_bytes(extractor), **arrays), where="model")


def test_other_versions_are_refused(extractor):
    with np.load(io.BytesIO(to_bytes(extractor))) as file:
        form = file["form"].tobytes()
    other = np.frombuffer(form.replace(b'"version": 3', b'"version": 0'), dtype=np.uint8)
    with pytest.raises(ModelError, match="another version"):
        from_bytes(changed(to_bytes(extractor), form=other))


def test_arrays_that_changed_places_are_found(extractor):
    content = to_bytes(extractor)
    with np.load(io.BytesIO(content)) as file:
        arrays = {name: file[name] for name in file.files}
    arrays["card"] = np.frombuffer(b'{"scenarios": ["b"]}', dtype=np.uint8)
    with pytest.raises(ModelError, match="model: digest: the arrays are not those"):
        from_bytes(write_arrays(arrays), where="model")
    del arrays[DIGEST]
    with pytest.raises(ModelError, match="another version"):
        from_bytes(write_arrays(arrays), where="model")


def test_the_version_without_a_digest_is_read(extractor):
    with np.load(io.BytesIO(to_bytes(extractor))) as file:
        form = file["form"].tobytes().replace(b'"version": 3', b'"version": 2')
    old = changed(to_bytes(extractor), sealed=False, form=np.frombuffer(form, dtype=np.uint8))
    assert to_bytes(from_bytes(old)) == to_bytes(extractor)


def test_the_one_that_comes_along_says_what_it_was_trained_on():
    assert default_extractor().card["scenarios"]


def test_a_card_is_any_json(extractor):
    card = {"corpora": {"é": "x"}, "l2": 1.0}
    changed_card = replace(extractor, card=card)
    assert isinstance(changed_card, Extractor)
    assert from_bytes(to_bytes(changed_card)).card == card


def test_the_extractor_that_comes_along_is_up_to_date():
    card = default_extractor().card
    assert card["recipe"] == recipe(), "train it again: docs/language.md says how"
    assert card["l2"] == DEFAULT_L2
