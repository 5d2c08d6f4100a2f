"""The parser: what it learns, and its file."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from g3.errors import CorpusError, ModelError
from g3.estimator import NotFittedError
from g3.language.parsing.sdc_parser import DEFAULT_L2, SDCParser, default_parser
from g3.language.parsing.training import parser_training
from g3.language.parsing.training.parser_training import RETYPED, prepare, retyped
from g3.language.parsing.words import cut
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


@pytest.fixture(scope="module", autouse=True)
def few_steps():
    """Enough to learn three commands by, which all parsers here are taught."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parser_training, "LEAST_STEPS", 60)
        yield


@pytest.fixture(scope="module")
def parser():
    return SDCParser(layers=0, card={"scenarios": ["a"]}).fit(trees())


@pytest.fixture(scope="module")
def content(parser, tmp_path_factory):
    path = tmp_path_factory.mktemp("parser") / "model"
    parser.save(path)
    return path.read_bytes()


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Reads an parser from bytes, in a file named model."""
    monkeypatch.chdir(tmp_path)

    def read(content):
        Path("model").write_bytes(content)
        return SDCParser.load("model")

    return read


def saved(parser, path):
    parser.save(path)
    return path.read_bytes()


def test_a_file_and_back(parser, content, load, tmp_path):
    again = load(content)
    assert saved(again, tmp_path / "again") == content
    assert again.card_ == {"l2": DEFAULT_L2, "layers": 0, "scenarios": ["a"]}
    texts, expected = zip(*trees(), strict=True)
    assert parser.predict(texts) == again.predict(texts) == list(expected)


@pytest.fixture(scope="module")
def tuned():
    """A parser whose encoder has learned, too."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parser_training, "LEAST_STEPS_OF_LAYERS", 12)
        return SDCParser(layers=1).fit(trees())


def test_a_file_with_changed_layers_and_back(tuned, content, load, tmp_path):
    written = saved(tuned, tmp_path / "first")
    assert len(content) < len(written) < len(content) + 2_000_000
    again = load(written)
    assert saved(again, tmp_path / "again") == written
    assert again.layers == 1
    assert again.predict(READ) == tuned.predict(READ)
    before, after = default_parser().encoder_, again.encoder_
    assert [a is b for a, b in zip(before.layers, after.layers, strict=True)] == [True] * 5 + [
        False
    ]


@pytest.mark.parametrize("shape", [(4, 8, 8), (3, 384, 384)])
def test_layers_of_another_size_are_refused(tuned, load, tmp_path, shape):
    written = saved(tuned, tmp_path / "first")
    with pytest.raises(ModelError, match=r"model: the parser can't be read"):
        load(changed(written, square=np.zeros(shape, dtype=np.int8)))


@pytest.mark.parametrize("known", ["trees", "lessons", "texts"])
def test_whatever_it_is_told_the_trees_by_it_learns_the_same(parser, content, known, tmp_path):
    texts, sdcs = zip(*trees(), strict=True)
    taught = {"trees": (trees(),), "lessons": (prepare(trees()),), "texts": (texts, sdcs)}[known]
    again = type(parser)(**parser.get_params())
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


def test_a_probability_for_each_tree(parser):
    text = "the crate up there by it you lift on that left"
    [one, other] = parser.predict_proba([text, ""], n_best=3)
    chances = [tree.probability for tree in one.trees]
    assert 2 <= len(chances) <= 3
    assert chances == sorted(chances, reverse=True)
    assert 0 < sum(chances) <= 1 + 1e-9
    assert one.sdcs == parser.predict([one.text])[0]
    assert (other.trees, other.note) == ((), "the text has no words")


READ = (*TAUGHT, "Put the crate on it", "", "left")


@pytest.fixture(scope="module")
def alone(parser):
    """What is made of each command by itself."""
    return {text: parser.predict([text])[0] for text in READ}


@settings(deadline=None, max_examples=25)
@given(st.lists(st.sampled_from(READ), max_size=6))
def test_each_command_is_read_by_itself_cut_or_not(parser, alone, texts):
    analyses = [cut(text) for text in texts]
    expected = [alone[text] for text in texts]
    mixed = [a if i % 2 else text for i, (a, text) in enumerate(zip(analyses, texts, strict=True))]
    assert parser.predict(texts) == expected
    assert parser.predict(analyses) == expected
    assert parser.predict(mixed) == expected


def test_before_it_is_fitted_it_says_what_to_do(tmp_path):
    for use in (SDCParser().predict, lambda _: SDCParser().save(tmp_path / "x")):
        with pytest.raises(NotFittedError, match=r"this SDCParser isn't fitted yet \(call its"):
            use(["Go left"])
    assert list(tmp_path.iterdir()) == []


def test_nothing_to_learn_from():
    with pytest.raises(CorpusError, match="no commands with annotated SDC trees"):
        SDCParser().fit([("", ())])


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
        SDCParser().fit(texts, trees)


def test_one_command_is_no_list_of_commands(parser):
    with pytest.raises(ModelError, match=r"predict\(\[command\]\)"):
        parser.predict("Lift the crate")


def test_a_file_that_is_missing(tmp_path):
    with pytest.raises(ModelError, match=r"no: the model can't be read: .*train parser"):
        SDCParser.load(tmp_path / "no")


def arrays_of(content):
    with np.load(io.BytesIO(content)) as file:
        return dict(file)


def changed(content, **arrays):
    """An parser with other arrays, whose digest is right."""
    found = {name: own for name, own in arrays_of(content).items() if name != DIGEST} | arrays
    return write_arrays({n: array for n, array in found.items() if array is not None}, sealed=True)


@pytest.mark.parametrize(
    "arrays",
    [
        {"arcs": np.zeros((3, 3))},
        {"arcs": np.zeros((3, 3), dtype=np.float16)},
        {"root": None},
        {"card": np.frombuffer(b"nothing", dtype=np.uint8)},
        {"form": np.frombuffer(b"[]", dtype=np.uint8)},
    ],
)
def test_damaged_files_are_refused(content, load, arrays):
    with pytest.raises(ModelError, match=r"model: .*(can't be read|is missing|has the type)"):
        load(changed(content, **arrays))


def form_of(content, version):
    """The form of the file, in another version."""
    form = arrays_of(content)["form"].tobytes().replace(b'"version": 4', version)
    return np.frombuffer(form, dtype=np.uint8)


def test_other_versions_are_refused(content, load):
    with pytest.raises(ModelError, match="another version"):
        load(changed(content, form=form_of(content, b'"version": 0')))


def test_arrays_that_changed_places_are_found(content, load):
    arrays = arrays_of(content)
    arrays["card"] = np.frombuffer(b'{"scenarios": ["b"]}', dtype=np.uint8)
    with pytest.raises(ModelError, match="model: digest: the arrays are not those"):
        load(write_arrays(arrays))


def test_the_one_that_comes_along_says_what_it_was_trained_on():
    assert default_parser().card_["corpora"]["treebank"]


def test_a_card_is_any_json(tmp_path):
    card = {"corpora": {"é": "x"}, "more": 1}
    SDCParser(l2=2.0, layers=0, card=card).fit(trees()).save(tmp_path / "x")
    found = SDCParser.load(tmp_path / "x")
    assert found.card_ == {**card, "l2": 2.0, "layers": 0}
    assert found.l2 == 2.0
