"""The extractor: what it learns, and its file."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from g3.errors import CorpusError, ModelError
from g3.estimator import NotFittedError
from g3.language.parsing.extractor import DEFAULT_L2, SDCExtractor, default_extractor
from g3.language.parsing.spacy_pipeline import analyse
from g3.language.parsing.training.extractor_training import (
    RETYPED,
    prepare,
    recipe,
    retyped,
)
from g3.sdc.sdc_notation import parse_brackets
from g3.storage.array_file import DIGEST, write_arrays

TAUGHT = {
    "Lift the crate on the truck": (
        "EVENT(r = Lift, l = OBJ(f = OBJ(f = the crate), r = on, l = OBJ(f = the truck)))"
    ),
    "Go left": "EVENT(r = Go left)",
    "Put it on the truck": (
        "EVENT(r = Put, l = OBJ(f = it), l2 = PLACE(r = on, l = OBJ(f = the truck)))"
    ),
}


def trees():
    return [(text, parse_brackets(tree, command=text)) for text, tree in TAUGHT.items()]


@pytest.fixture(scope="module")
def extractor():
    return SDCExtractor(card={"scenarios": ["a"]}).fit(trees())


@pytest.fixture(scope="module")
def content(extractor, tmp_path_factory):
    path = tmp_path_factory.mktemp("extractor") / "model"
    extractor.save(path)
    return path.read_bytes()


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Reads an extractor from bytes, in a file named model."""
    monkeypatch.chdir(tmp_path)

    def read(content):
        Path("model").write_bytes(content)
        return SDCExtractor.load("model")

    return read


def saved(extractor, path):
    extractor.save(path)
    return path.read_bytes()


def test_a_file_and_back(extractor, content, load, tmp_path):
    again = load(content)
    assert saved(again, tmp_path / "again") == content
    assert again.card_ == {"l2": DEFAULT_L2, "scenarios": ["a"], "recipe": recipe()}
    texts, expected = zip(*trees(), strict=True)
    assert extractor.predict(texts) == again.predict(texts) == list(expected)


@pytest.mark.parametrize("known", ["trees", "lessons", "texts"])
def test_whatever_it_is_told_the_trees_by_it_learns_the_same(extractor, content, known, tmp_path):
    texts, sdcs = zip(*trees(), strict=True)
    taught = {"trees": (trees(),), "lessons": (prepare(trees()),), "texts": (texts, sdcs)}[known]
    again = type(extractor)(**extractor.get_params())
    assert again.fit(*taught) is again
    assert saved(again, tmp_path / "again") == content


def test_some_lessons_are_learned_again_without_articles_and_punctuation():
    text = "Lift the crate, please."
    tree = "EVENT(r = Lift, l = OBJ(f = the crate))"
    lesson = (text, parse_brackets(tree, command=text))
    short, run_on = retyped(prepare([lesson] * RETYPED))
    assert short.command.text == "Lift crate, please."
    assert short.sdcs == parse_brackets(tree.replace("the ", ""), command=short.command.text)
    assert run_on.command.text == "Lift the crate please"
    assert run_on.sdcs == parse_brackets(tree, command=run_on.command.text)
    assert retyped(prepare([("Go left", parse_brackets(TAUGHT["Go left"]))])) == []


def test_a_probability_for_each_tree(extractor):
    [one, other] = extractor.predict_proba(["Lift the crate on the truck", ""], n_best=3)
    chances = [tree.probability for tree in one.trees]
    assert 2 <= len(chances) <= 3
    assert chances == sorted(chances, reverse=True)
    assert 0 < sum(chances) <= 1 + 1e-9
    assert one.sdcs == extractor.predict([one.text])[0]
    assert (other.trees, other.note) == ((), "the text has no words")


READ = (*TAUGHT, "Put the crate on it", "", "left")


@pytest.fixture(scope="module")
def alone(extractor):
    """What is made of each command by itself."""
    return {text: extractor.predict([text])[0] for text in READ}


@settings(deadline=None, max_examples=25)
@given(st.lists(st.sampled_from(READ), max_size=6))
def test_each_command_is_read_by_itself_analysed_or_not(extractor, alone, texts):
    analyses = list(analyse(texts))
    expected = [alone[text] for text in texts]
    mixed = [a if i % 2 else text for i, (a, text) in enumerate(zip(analyses, texts, strict=True))]
    assert extractor.predict(texts) == expected
    assert extractor.predict(analyses) == expected
    assert extractor.predict(mixed) == expected


def test_before_it_is_fitted_it_says_what_to_do(tmp_path):
    for use in (SDCExtractor().predict, lambda _: SDCExtractor().save(tmp_path / "x")):
        with pytest.raises(NotFittedError, match=r"this SDCExtractor isn't fitted yet \(call its"):
            use(["Go left"])
    assert list(tmp_path.iterdir()) == []


def test_nothing_to_learn_from():
    with pytest.raises(CorpusError, match="no commands with annotated SDC trees"):
        SDCExtractor().fit([("", ())])


@pytest.mark.parametrize(
    ("texts", "trees", "fix"),
    [
        (["Go left"], None, "fit\\(texts, trees\\)"),
        ("Go left", None, "list of commands"),
        (["Go left"], [], "a tree for each"),
    ],
)
def test_texts_without_trees_are_refused(texts, trees, fix):
    with pytest.raises(ModelError, match=fix):
        SDCExtractor().fit(texts, trees)


def test_one_command_is_no_list_of_commands(extractor):
    with pytest.raises(ModelError, match=r"predict\(\[command\]\)"):
        extractor.predict("Lift the crate")


def test_a_file_that_is_missing(tmp_path):
    with pytest.raises(ModelError, match=r"no: the model can't be read: No such file .*train sdc"):
        SDCExtractor.load(tmp_path / "no")


def arrays_of(content):
    with np.load(io.BytesIO(content)) as file:
        return dict(file)


def changed(content, *, sealed=True, **arrays):
    """An extractor with other arrays, whose digest is right."""
    found = {name: own for name, own in arrays_of(content).items() if name != DIGEST} | arrays
    return write_arrays(
        {n: array for n, array in found.items() if array is not None}, sealed=sealed
    )


@pytest.mark.parametrize(
    "arrays",
    [
        {"role_weights": np.zeros((3, 3))},
        {"role_keys": None},
        {"card": np.frombuffer(b"nothing", dtype=np.uint8)},
        {"attachment_weights": np.zeros((1, 1))},
    ],
)
def test_damaged_files_are_refused(content, load, arrays):
    with pytest.raises(ModelError, match=r"model: .*(can't be read|is missing|has the type)"):
        load(changed(content, **arrays))


def form_of(content, version):
    """The form of the file, in another version."""
    form = arrays_of(content)["form"].tobytes().replace(b'"version": 3', version)
    return np.frombuffer(form, dtype=np.uint8)


def test_other_versions_are_refused(content, load):
    with pytest.raises(ModelError, match="another version"):
        load(changed(content, form=form_of(content, b'"version": 0')))


def test_arrays_that_changed_places_are_found(content, load):
    arrays = arrays_of(content)
    arrays["card"] = np.frombuffer(b'{"scenarios": ["b"]}', dtype=np.uint8)
    with pytest.raises(ModelError, match="model: digest: the arrays are not those"):
        load(write_arrays(arrays))
    del arrays[DIGEST]
    with pytest.raises(ModelError, match="another version"):
        load(write_arrays(arrays))


def test_the_version_without_a_digest_is_read(content, load, tmp_path):
    old = changed(content, sealed=False, form=form_of(content, b'"version": 2'))
    assert saved(load(old), tmp_path / "again") == content


def test_the_one_that_comes_along_says_what_it_was_trained_on():
    assert default_extractor().card_["scenarios"]


def test_a_card_is_any_json(tmp_path):
    card = {"corpora": {"é": "x"}, "recipe": "old"}
    SDCExtractor(l2=2.0, card=card).fit(trees()).save(tmp_path / "x")
    found = SDCExtractor.load(tmp_path / "x")
    assert found.card_ == {**card, "l2": 2.0, "recipe": recipe()}
    assert found.l2 == 2.0


def test_the_extractor_that_comes_along_is_up_to_date():
    card = default_extractor().card_
    assert card["recipe"] == recipe(), "train it again: docs/language.md says how"
    assert card["l2"] == DEFAULT_L2
