"""Features of corpora on disk, and training on them: the same model as in memory."""

from __future__ import annotations

import shutil
from dataclasses import astuple

import numpy as np
import pytest

from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.labelled_corpus import Options, labelled_examples
from corpus_tools.runtime.parallel import Workers
from corpus_tools.shards.shard_files import MANIFEST, read_manifest, read_shard
from corpus_tools.shards.shard_making import to_shard, write_shards
from corpus_tools.shards.shard_training import fit_on_shards
from g3.errors import FormatError
from g3.features.feature_registry import select
from g3.features.matrix import fit_space, prior_scale
from g3.learning import crf
from g3.learning.examples import labels, to_batch
from g3.learning.grounding_model import GroundingModel
from tests.damage import damaged
from tests.tiny_corpus import tiny_corpus

TIGHT = 1e-9


@pytest.fixture(scope="module")
def corpora(tmp_path_factory):
    """Two corpora of other worlds, with features of their own."""
    folder = tmp_path_factory.mktemp("corpora")
    tiny_corpus().save(folder / "one")
    tiny_corpus(("to_truck", "put_on_truck"), shift=2.5).save(folder / "two")
    return str(folder / "one"), str(folder / "two")


@pytest.fixture(scope="module")
def items(corpora):
    return [item for name in corpora for item in labelled_examples(Corpus.load(name))]


def by_name(space, weights):
    return {space.name(i): weight for i, weight in enumerate(weights)}


def test_rows_with_their_counts_are_the_examples(items):
    shard = to_shard([*items, *items[:9]], Options())
    space, matrix = fit_space(to_batch(items), select())
    assert int(shard.right.sum() + shard.wrong.sum()) == len(items) + 9
    found, expected = {}, {}
    for i, (right, wrong) in enumerate(zip(shard.right, shard.wrong, strict=True)):
        own = shard.keys[shard.features[shard.offsets[i] : shard.offsets[i + 1]]]
        base, word = np.divmod(own, len(shard.words))
        names = {(shard.bases[b], shard.words[w]) for b, w in zip(base, word, strict=True)}
        found[frozenset(names)] = (right, wrong)
    for i, item in enumerate([*items, *items[:9]]):
        row = i % len(items)
        own = space.keys[matrix.indices[matrix.indptr[row] : matrix.indptr[row + 1]]]
        base, word = np.divmod(own, len(space.words))
        names = frozenset((space.bases[b], space.words[w]) for b, w in zip(base, word, strict=True))
        right, wrong = expected.get(names, (0, 0))
        expected[names] = (right + item.correct, wrong + (not item.correct))
    assert found == expected
    assert len(found) < len(items)


@pytest.fixture(scope="module")
def shards(corpora, tmp_path_factory):
    """A folder with several shards of each corpus."""
    folder = tmp_path_factory.mktemp("shards")
    manifest, failures = write_shards(corpora, folder, Options(), workers=Workers(), size=20)
    assert not failures
    return folder, manifest


@pytest.mark.parametrize("optimizer", crf.METHODS)
def test_the_optimum_is_that_in_memory(shards, items, optimizer):
    folder, manifest = shards
    assert len(manifest.shards) == 5
    assert manifest.examples == len(items)
    model = fit_on_shards(
        GroundingModel(l2=0.5, optimizer=optimizer),
        folder,
        manifest,
        workers=Workers(),
        tolerance=TIGHT,
    )
    space, matrix = fit_space(to_batch(items), select())
    expected = crf.train(matrix, labels(items), l2=0.5 / prior_scale(space) ** 2, tolerance=TIGHT)
    assert by_name(model.space_, model.weights_) == pytest.approx(
        by_name(space, expected), abs=1e-6
    )


@pytest.mark.slow
def test_jobs_change_no_byte(shards, corpora, tmp_path):
    folder, manifest = shards
    again, _ = write_shards(corpora, tmp_path, Options(), workers=Workers(jobs=2), size=20)
    assert again == manifest
    for path in tmp_path.iterdir():
        assert path.read_bytes() == (folder / path.name).read_bytes()
    one, two = (
        fit_on_shards(GroundingModel(), folder, manifest, workers=Workers(jobs), tolerance=2.0)
        for jobs in (1, 2)
    )
    assert one.weights_.tobytes() == two.weights_.tobytes()
    assert sorted(p.name for p in folder.iterdir()) == sorted(p.name for p in tmp_path.iterdir())


def test_commands(corpora, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["shards", *corpora, "--out", "shards", "--ablate", "labels"]) == 0
    assert "wrote 2 shards" in capsys.readouterr().out
    assert run(["train", "g3", "--shards", "shards", "--out", "m", "--l2", "0.5"]) == 0
    out = capsys.readouterr().out
    assert "shards shards: 74 examples (37 positive, 37 random)" in out
    model, card = GroundingModel.load(tmp_path / "m"), read_manifest(tmp_path / "shards")
    assert model.l2 == 0.5
    assert not any("/labels/" in name for name in model.space_.bases)
    assert list(card.corpora) == list(corpora)


def test_a_corpus_that_cannot_be_read_is_left_out(corpora, tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    arguments = [corpora[0], str(tmp_path / "empty"), "--out", str(tmp_path / "out")]
    assert run(["shards", *arguments]) == 2
    assert f"{tmp_path / 'empty'}: left out" in capsys.readouterr().err
    assert list(read_manifest(tmp_path / "out").corpora) == [corpora[0]]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "either --corpus or --shards"),
        (["--corpus", "x", "--shards", "y"], "either --corpus or --shards"),
        (["--shards", "y", "--seed", "0"], "--seed is an option of `ct shards`"),
        (["--corpus", "x", "--jobs", "2"], "--jobs goes with --shards"),
        (["--shards", "y"], "there are no shards"),
    ],
)
def test_what_does_not_go_together(arguments, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["train", "g3", *arguments, "--out", "m"]) == 2
    assert said in capsys.readouterr().err


def test_damaged_files(shards, tmp_path, capsys):
    folder, manifest = shards
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    (copy / manifest.shards[1].file).write_bytes(b"PK")
    with pytest.raises(FormatError, match="can't be read"):
        fit_on_shards(GroundingModel(), copy, manifest, workers=Workers())
    text = (copy / MANIFEST).read_text()
    (copy / MANIFEST).write_text(text.replace('"format_version": 3', '"format_version": 0'))
    with pytest.raises(FormatError, match="another version"):
        read_manifest(copy)
    assert run(["shards", "x", "--out", str(copy)]) == 2
    assert "isn't empty" in capsys.readouterr().err
    assert read_shard(folder / manifest.shards[0].file).right.sum() > 0


def test_damage_to_any_file_is_found(shards, tmp_path):
    """Words and sums of a shard, fields of the manifest, one shard in place of another."""
    folder, manifest = shards
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    record = manifest.shards[0]
    path = copy / record.file
    expected = read_shard(path)
    for _, content in damaged(path.read_bytes(), 200, seed=1):
        path.write_bytes(content)
        try:
            found = read_shard(path, record.digest)
        except FormatError as error:
            assert record.file in str(error)  # noqa: PT017 - most raise, not all
        else:
            for one, other in zip(astuple(found), astuple(expected), strict=True):
                assert np.array_equal(one, other)
    shutil.copy(folder / manifest.shards[1].file, path)
    with pytest.raises(FormatError, match=r"not the shard that shards\.json names"):
        fit_on_shards(GroundingModel(), copy, manifest, workers=Workers())
    path = copy / MANIFEST
    for _, content in damaged(path.read_bytes(), 200, seed=2):
        path.write_bytes(content)
        try:
            assert read_manifest(copy) == manifest
        except FormatError as error:
            assert MANIFEST in str(error)  # noqa: PT017 - as above


def test_a_damaged_shard_is_made_again(shards, corpora, tmp_path):
    folder, manifest = shards
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    (copy / MANIFEST).unlink()
    path = copy / manifest.shards[0].file
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    again, _ = write_shards(corpora, copy, Options(), workers=Workers(), size=20)
    assert again == manifest
    assert path.read_bytes() == (folder / path.name).read_bytes()


def test_what_was_stopped_goes_on(shards, corpora, tmp_path):
    folder, manifest = shards
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    (copy / MANIFEST).unlink()
    kept, lost, *_ = (shard.file for shard in manifest.shards)
    (copy / lost).rename(copy / f".{lost}.new-0123abcd")  # as a killed process leaves it
    (copy / "00009-00000.npz").write_bytes(b"of another corpus")
    before = (copy / kept).stat().st_mtime_ns
    again, _ = write_shards(corpora, copy, Options(), workers=Workers(), size=20)
    assert again == manifest
    assert (copy / kept).stat().st_mtime_ns == before
    assert (copy / lost).read_bytes() == (folder / lost).read_bytes()
    assert {p.name for p in copy.iterdir()} == {p.name for p in folder.iterdir()}


def test_shards_of_other_features_are_made_again(shards, corpora, tmp_path):
    folder, _ = shards
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    (copy / MANIFEST).unlink()
    without = Options(ablated=("labels",))
    again, _ = write_shards(corpora, copy, without, workers=Workers(), size=20)
    assert "labels" not in again.sets
    first = read_shard(copy / again.shards[0].file)
    assert not any("/labels/" in base for base in first.bases)
