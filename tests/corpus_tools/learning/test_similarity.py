from __future__ import annotations

import bz2
import gzip
import json
from pathlib import Path

import pytest
from numpy.testing import assert_array_equal

from corpus_tools.cli.console import run
from corpus_tools.learning.tag_lists import build_table
from g3.errors import FormatError, ModelError
from g3.features.feature_registry import catalogue, select
from g3.language.similarity.cooccurrence import count_list, table_from_bytes
from g3.learning.examples import examples
from g3.learning.grounding_model import GroundingModel
from tests.g3.language.installed import needs_wordnet
from tests.processes import ct
from tests.tiny_corpus import tiny_corpus

TEXT = "# three pictures\ntruck,tires\ntruck,trailer\n\ndog\n"


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("tags.txt", TEXT.encode()),
        ("tags.gz", gzip.compress(TEXT.encode())),
        ("tags.txt.bz2", bz2.compress(TEXT.encode())),
    ],
    ids=["plain", "gzip", "bzip2"],
)
def test_a_list_in_any_packing_gives_the_table_of_its_lines(
    tmp_path: Path, name: str, content: bytes
) -> None:
    (tmp_path / name).write_bytes(content)
    table = build_table(tmp_path / name, tmp_path / "tags.npz", limit=10)
    in_memory = count_list(TEXT.splitlines())
    read = table_from_bytes((tmp_path / "tags.npz").read_bytes())
    for found in (table, read):
        assert (found.tags, found.images) == (in_memory.tags, in_memory.images)
        assert_array_equal(found.together.toarray(), in_memory.together.toarray())


def test_only_the_most_frequent_tags_are_kept(tmp_path: Path) -> None:
    (tmp_path / "tags").write_text(TEXT)
    assert build_table(tmp_path / "tags", tmp_path / "t.npz", limit=2).tags == ("dog", "truck")


@pytest.mark.parametrize("content", [b"", b"# nothing\n", None])
def test_a_list_without_tags(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "tags.gz"
    if content is not None:
        path.write_bytes(gzip.compress(content))
    with pytest.raises(FormatError) as caught:
        build_table(path, tmp_path / "t.npz", limit=2)
    assert caught.value.where == str(path)
    assert not (tmp_path / "t.npz").exists()


def test_the_command_builds_a_table_that_the_measure_reads(tmp_path: Path, capsys) -> None:
    (tmp_path / "tags.txt").write_text("zeppelin,trailer\nzeppelin,trailer\npallet\n")
    out = tmp_path / "tags.npz"
    assert run(["similarity", "build", str(tmp_path / "tags.txt"), "--out", str(out)]) == 0
    assert capsys.readouterr().out.startswith("3 images, 3 tags\n")
    arguments = ("similarity", "show", "zeppelin", "--label", "trailer", "--format", "json")
    shown = json.loads(ct(*arguments, CT_TAGS=str(out)).stdout)
    values = {record["measure"]: record["similarity"] for record in shown}
    assert values["tag-given"] == values["tag-npmi"] == 1


def test_without_wordnet_the_command_says_so_and_shows_the_rest(tmp_path: Path) -> None:
    done = ct("similarity", "show", "skid", "--label", "pallet", CT_WORDNET=str(tmp_path))
    assert done.returncode == 0
    assert "wordnet-base" in done.stderr
    assert "domain" in done.stdout


def small_model(*sets: str) -> GroundingModel:
    return GroundingModel(features=sets).fit(examples(tiny_corpus().annotations))


@needs_wordnet
def test_a_model_that_used_wordnet_says_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = small_model("word-wordnet")
    model.save(tmp_path / "m")
    assert json.loads((tmp_path / "m.json").read_text())["data"].keys() == {"word-wordnet"}
    GroundingModel.load(tmp_path / "m")
    monkeypatch.setenv("CT_WORDNET", str(tmp_path))
    with pytest.raises(ModelError, match="wordnet-base") as caught:
        GroundingModel.load(tmp_path / "m")
    assert "word-wordnet" in caught.value.where
    with pytest.raises(ModelError, match="wordnet-base"):
        _ = model.sets


def test_a_model_is_refused_where_the_tag_table_is_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small_model("word-tags").save(tmp_path / "m")
    GroundingModel.load(tmp_path / "m")
    (tmp_path / "tags.txt").write_text("truck tire\n")
    monkeypatch.setenv("CT_TAGS", str(tmp_path / "tags.txt"))
    with pytest.raises(ModelError, match="other data"):
        GroundingModel.load(tmp_path / "m")


def test_without_wordnet_its_features_are_off_with_one_note(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("CT_WORDNET", str(tmp_path))
    names = {s.name for s in catalogue() if s.default}
    assert {s.name for s in select()} == {s.name for s in select()} == names - {"word-wordnet"}
    assert [r.levelname for r in caplog.records] == ["WARNING"]
    with pytest.raises(ModelError, match="wordnet-base"):
        select(plus=["word-wordnet"])
