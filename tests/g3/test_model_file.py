from __future__ import annotations

import contextlib
import hashlib
import io
import json

import msgspec
import numpy as np
import pytest

from corpus_tools.cli.console import run
from corpus_tools.corpus.labelled_corpus import scenario_ids
from g3.errors import ModelError
from g3.features.feature_registry import CATALOGUE_VERSION, select
from g3.learning.examples import examples
from g3.learning.grounding_model import GroundingModel
from g3.learning.load_choice import Load, LoadChoice
from g3.learning.model_file import (
    ModelCard,
    card_digest,
    model_files,
    read_card,
)
from tests.tiny_corpus import SCENARIOS, tiny_corpus


@pytest.fixture(scope="module")
def items():
    return examples(tiny_corpus().annotations)


@pytest.fixture(scope="module")
def model(items):
    card = {"corpus_hash": "sha256:1", "scenarios": ("s1",), "training": {"seed": 3}}
    return GroundingModel(card=card).fit(items)


@pytest.fixture
def path(model, tmp_path):
    model.save(tmp_path / "g3.npz")
    return tmp_path / "g3.npz"


def digest(content):
    return f"sha256:{hashlib.sha256(content).hexdigest()}"


def edit_card(path, **changes):
    """Change fields of a card; its digest is right after that, if it can be read at all."""
    card_path = model_files(path)[1]
    card = json.loads(card_path.read_text()) | changes
    card = {k: v for k, v in card.items() if v is not None}
    with contextlib.suppress(msgspec.MsgspecError):
        card["digest"] = card_digest(msgspec.convert(card, ModelCard, strict=False))
    card_path.write_text(json.dumps(card | changes if "digest" in changes else card))


def replace_arrays(path, **arrays):
    """Put other arrays into a model whose digest is right."""
    out = io.BytesIO()
    np.savez(out, **arrays)
    path.write_bytes(out.getvalue())
    edit_card(path, arrays=digest(out.getvalue()))


@pytest.mark.parametrize("name", ["g3", "g3.npz", "g3.json", "v1.2", "v1.2.npz"])
def test_a_model_comes_back(model, items, tmp_path, name):
    model.save(tmp_path / name)
    loaded = GroundingModel.load(tmp_path / name, corpus_hash="sha256:1")
    stem = name.removesuffix(".npz").removesuffix(".json")
    assert sorted(p.name for p in tmp_path.iterdir()) == [f"{stem}.json", f"{stem}.npz"]
    assert loaded.space_.keys.tobytes() == model.space_.keys.tobytes()
    assert loaded.weights_.tobytes() == model.weights_.tobytes()
    assert (loaded.space_.sets, loaded.space_.bases) == (model.space_.sets, model.space_.bases)
    assert loaded.space_.words == model.space_.words
    assert (loaded.l2, loaded.card, loaded.sets) == (model.l2, model.card, model.sets)
    assert loaded.predict_proba(items).tobytes() == model.predict_proba(items).tobytes()


def test_a_model_that_was_read_gives_the_same_bytes(path, tmp_path):
    GroundingModel.load(path).save(tmp_path / "again")
    for one, other in zip(model_files(path), model_files(tmp_path / "again"), strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_the_card_tells_of_the_training(path, model):
    card = read_card(path)
    assert (card.scenarios, card.training) == (("s1",), {"seed": 3})
    assert card.features == len(model.space_)


def test_another_corpus_is_refused(path):
    with pytest.raises(ModelError, match=r"g3.json: corpus_hash: it was trained on another corpus"):
        GroundingModel.load(path, corpus_hash="sha256:2")


@pytest.mark.parametrize("suffix", [".npz", ".json"])
def test_a_missing_file_is_refused(path, suffix):
    path.with_suffix(suffix).unlink()
    with pytest.raises(ModelError, match=rf"g3\{suffix}: the model can't be read: No such file"):
        GroundingModel.load(path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"schema_version": 1},
            "schema_version: the file's version is 1, this program reads 2",
        ),
        ({"schema_version": None}, "the file's version is none"),
        ({"catalogue_version": CATALOGUE_VERSION + 1}, "catalogue_version: it needs version"),
        ({"sets": ["labels", "smell"]}, "sets: there is no feature set 'smell'"),
        ({"weights": [1]}, "g3.json: the file is damaged: .*unknown field `weights`"),
        ({"l2": "much"}, r"g3.json: the file is damaged: Expected `float`.*\$\.l2"),
        ({"arrays": "sha256:0"}, "g3.npz: the content is not what was written"),
        ({"features": 3}, r"g3.npz: keys: the array has the shape \(\d+,\), expected \(3,\)"),
        (
            {"words": [""], "bases": ["OBJECT/bias"]},
            "g3.npz: keys: they are not ascending products",
        ),
    ],
)
def test_a_card_that_does_not_fit_is_refused(path, changes, message):
    edit_card(path, **changes)
    with pytest.raises(ModelError, match=message):
        GroundingModel.load(path)


def test_every_value_of_a_card_is_under_its_digest(path):
    """Whatever a card says differently, by itself or with another's arrays, it is refused."""
    card_path = model_files(path)[1]
    original = card_path.read_text()
    card = json.loads(original)
    words = card["words"]
    others = {
        "program": "0",
        "corpus_hash": "sha256:2",
        "l2": 2.0,
        "words": [words[1], words[0], *words[2:]],
        "data": {"word-tags": "sha256:0"},
        "scenarios": [],
        "training": {"seed": 4},
        "digest": "",
    }
    for name, value in others.items():
        card_path.write_text(json.dumps(card | {name: value}))
        with pytest.raises(ModelError, match=r"g3.json: digest: the content is not what was writ"):
            GroundingModel.load(path)
    card_path.write_text(json.dumps(card, sort_keys=True))  # the same, written differently
    GroundingModel.load(path)


@pytest.mark.parametrize("content", [b"", b"[]", b"{", b"null", b"\xff"])
def test_a_card_that_is_no_json_object_is_refused(path, content):
    path.with_suffix(".json").write_bytes(content)
    with pytest.raises(ModelError, match=r"g3.json: the file is damaged"):
        GroundingModel.load(path)


@pytest.mark.parametrize("keep", [0, 1, 200, -1])
def test_a_truncated_array_file_is_refused(path, keep):
    content = path.read_bytes()[:keep]
    path.write_bytes(content)
    with pytest.raises(ModelError, match=r"g3.npz: the content is not what was written"):
        GroundingModel.load(path)
    edit_card(path, arrays=digest(content))
    with pytest.raises(ModelError, match=r"g3.npz: the arrays can't be read"):
        GroundingModel.load(path)


def test_arrays_that_do_not_fit_are_refused(path, model):
    keys, weights = model.space_.keys, model.weights_
    for arrays, message in [
        ({"keys": keys}, "weights: the array is missing"),
        ({"keys": keys[::-1], "weights": weights}, "keys: they are not ascending"),
        ({"keys": keys - keys[0] - 1, "weights": weights}, "keys: they are not ascending"),
        ({"keys": keys, "weights": weights.astype(np.float32)}, "weights: .* has the type <f4"),
        ({"keys": keys, "weights": weights[:-1]}, "weights: the array has the shape"),
        ({"keys": keys, "weights": weights * np.inf}, "weights: a number is not finite"),
        ({"keys": keys, "weights": weights.astype(object)}, "weights: .* has the type .O"),
    ]:
        replace_arrays(path, **arrays)
        with pytest.raises(ModelError, match=message):
            GroundingModel.load(path)


def test_train_writes_a_model_that_says_where_it_comes_from(tmp_path, capsys):
    corpus = tiny_corpus()
    corpus.save(tmp_path / "tiny")
    arguments = ["--corpus", str(tmp_path / "tiny"), "--ablate", "labels", "--l2", "2"]
    assert run(["train", "g3", *arguments, "--out", str(tmp_path / "m.npz")]) == 0
    out = capsys.readouterr().out
    assert "corpus tiny: 44 examples (22 positive, 22 random)" in out
    assert f"wrote {tmp_path / 'm.npz'} and {tmp_path / 'm.json'}" in out
    model, card = (
        GroundingModel.load(tmp_path / "m", corpus_hash=corpus.hash),
        read_card(tmp_path / "m"),
    )
    assert model.l2 == 2
    assert "labels" not in model.space_.sets
    assert set(card.scenarios) == scenario_ids(examples(corpus.annotations))
    assert [s.rpartition(" ")[0] for s in card.scenarios] == sorted(SCENARIOS)
    assert card.training["examples"] == {"positive": 22, "random": 22}


def test_train_with_hard_negatives_is_repeatable(tmp_path):
    tiny_corpus().save(tmp_path / "tiny")
    arguments = ["--corpus", str(tmp_path / "tiny"), "--negatives", "hard", "--seed", "5"]
    for name in ("one", "two"):
        assert run(["train", "g3", *arguments, "--out", str(tmp_path / name)]) == 0
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()
    assert read_card(tmp_path / "one").training["negatives"] == "hard"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--ablate", "smell"], "there is no feature set 'smell'"),
        (["--corpus", "nowhere"], "there is no folder or bundled corpus"),
        (["--out", "no/folder/m"], "there is no such folder"),
        (["--l2", "0"], "--l2"),
    ],
)
def test_train_refuses(tmp_path, capsys, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    tiny_corpus().save(tmp_path / "tiny")
    assert run(["train", "g3", "--corpus", "tiny", "--out", "m", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["tiny"]


def test_features_list_shows_the_catalogue(capsys):
    assert run(["features", "list"]) == 0
    text = capsys.readouterr().out
    assert run(["features", "list", "--format", "json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["catalogue_version"] == CATALOGUE_VERSION
    names = [record["name"] for record in content["feature_sets"]]
    assert {s.name for s in select()} == {
        record["name"] for record in content["feature_sets"] if record["default"]
    }
    for record in content["feature_sets"]:
        assert record["description"]
        assert record["types"]
        assert f"\n{record['name']}" in f"\n{text}"
        for column in record["columns"] or []:
            assert column["unit"]
            assert column["name"] in text
    assert names == sorted(names)
    rules = {record["name"]: record for record in content["potentials"]}
    for name, record in rules.items():
        assert record["description"]
        assert f"\n{name}\n" in text
    assert (rules["side"]["scores"], rules["side"]["weight"]) == ("factor", -2.9957)
    assert (rules["room"]["hard"], rules["room"]["weight"]) == (True, None)
    features, _, after = text.partition("\nPOTENTIALS")
    assert "\nlabels\n" in features
    assert "\nside\n" in after


CHOICES = [
    LoadChoice(
        ("lift", "the", word),
        (Load(("tire",), 4.0, 0.1), Load(("boxes",), 5.0, -0.1)),
        (word == "donut", word != "donut"),
        scenario=f"{word}{n}",
    )
    for word in ("donut", "parcel")
    for n in range(3)
]


def test_what_was_learned_of_loads_is_kept(items, tmp_path):
    model = GroundingModel().fit(items, load_choices=CHOICES)
    model.save(tmp_path / "g3")
    again = GroundingModel.load(tmp_path / "g3")
    assert again.load_chooser_.lexicon.corpora == model.load_chooser_.lexicon.corpora
    for choice in CHOICES:
        expected = model.load_chooser_.log_probability(choice)
        np.testing.assert_array_equal(again.load_chooser_.log_probability(choice), expected)
    loads = json.loads((tmp_path / "g3.json").read_text())["loads"]
    edit_card(tmp_path / "g3", loads={**loads, "likeness": "guessing"})
    with pytest.raises(ModelError, match="compared by guessing in training"):
        GroundingModel.load(tmp_path / "g3")
    edit_card(tmp_path / "g3", loads={**loads, "weights": [1.0]})
    with pytest.raises(ModelError, match="other features of loads"):
        GroundingModel.load(tmp_path / "g3")


def test_a_model_without_such_commands_has_none(path):
    assert "loads" not in json.loads(model_files(path)[1].read_text())
    assert GroundingModel.load(path).load_chooser_ is None
