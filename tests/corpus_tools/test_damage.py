"""Damaged models and corpora: each is refused, or holds the very content that was written.

``CT_DAMAGES=20`` tries twenty times as many.
"""

from __future__ import annotations

import shutil
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_reading import load_corpus
from corpus_tools.corpus.corpus_records import MANIFEST
from corpus_tools.corpus.corpus_writing import corpus_files, write_corpus
from g3.annotation import Judgment
from g3.errors import CorpusError, FormatError
from g3.language.parsing.extractor import default_extractor
from g3.language.parsing.extractor_file import from_bytes, to_bytes
from g3.language.similarity.cooccurrence import count_list, table_from_bytes, table_to_bytes
from g3.learning.examples import examples
from g3.learning.grounding_model import GroundingModel
from g3.learning.model_file import model_files, read_card
from tests.damage import damaged
from tests.tiny_corpus import tiny_corpus


@pytest.fixture(scope="module")
def corpus():
    tiny = tiny_corpus()
    return replace(
        tiny,
        commands={name: replace(c, subject="0123") for name, c in tiny.commands.items()},
        annotations=tuple(
            replace(a, command=replace(a.command, subject="0123")) for a in tiny.annotations
        ),
        judgments=tuple(
            Judgment(f"j{i}", "Go", "v", "w", "SA", f"rater {i}", "study") for i in range(20)
        ),
    )


@pytest.fixture(scope="module")
def model(corpus, tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "g3.npz"
    items = examples(corpus.annotations)
    card = {"scenarios": ("a", "b"), "training": {"seed": 3}}
    GroundingModel(card=card).fit(items).save(path)
    return path


def content_of(path: Path) -> tuple[object, ...]:
    loaded = GroundingModel.load(path)
    return read_card(path), loaded.space_.keys.tobytes(), loaded.weights_.tobytes()


def outcome(read, expected, where: str) -> str:
    """How it goes with a damaged file; an accepted one must hold what was written."""
    try:
        found = read()
    except CorpusError as error:
        problem = error
    else:
        assert found == expected, "damage was accepted"
        return "unchanged"
    assert where in str(problem)
    assert problem.fix
    return "refused"


@pytest.mark.parametrize("suffix", [".npz", ".json"])
def test_damaged_models(model, tmp_path, suffix):
    expected = content_of(model)
    for file in model_files(model):
        shutil.copy(file, tmp_path)
    path = tmp_path / f"g3{suffix}"
    outcomes = Counter()
    for what, content in damaged(path.read_bytes(), 500, seed=1):
        path.write_bytes(content)
        outcomes[outcome(lambda: content_of(path), expected, "g3."), what.split(",")[0]] += 1
    unchanged = sum(count for (how, _), count in outcomes.items() if how == "unchanged")
    assert unchanged <= (0 if suffix == ".npz" else sum(outcomes.values()) // 10), outcomes


def test_damaged_corpora(corpus, tmp_path):
    write_corpus(corpus, tmp_path / "c")
    names = list(corpus_files(corpus))
    expected = corpus_files(load_corpus(tmp_path / "c"))
    outcomes = Counter()
    for number, name in enumerate(names):
        path = tmp_path / "c" / name
        original = path.read_bytes()
        if not original:
            continue
        for _, content in damaged(original, 120, seed=number):
            path.write_bytes(content)
            read = lambda: corpus_files(load_corpus(tmp_path / "c"))  # noqa: E731
            outcomes[outcome(read, expected, str(tmp_path / "c")), name] += 1
        path.write_bytes(original)
    assert sum(outcomes.values()) >= 500
    unchanged = sum(count for (how, _), count in outcomes.items() if how == "unchanged")
    assert unchanged < sum(outcomes.values()) / 10, outcomes


def test_the_command_line_tells_each_in_one_line(corpus, model, tmp_path, capsys):
    write_corpus(corpus, tmp_path / "c")
    path = tmp_path / "c" / "trajectories.npz"
    for _, content in damaged(path.read_bytes(), 60, seed=7):
        path.write_bytes(content)
        status = run(["corpus", "stats", str(tmp_path / "c")])
        told = capsys.readouterr().err
        assert (status, told.count("\n")) in ((2, 1), (0, 0)), told
        assert status == 0 or "trajectories.npz" in told
        assert "unexpected" not in told


def test_damaged_extractors_and_tag_tables():
    """Each in one file, which holds its own digest."""
    default = default_extractor()
    extractor = to_bytes(default.roles_, default.attachments_, default.card_)
    for _, content in damaged(extractor, 60, seed=2):
        outcome(lambda c=content: to_bytes(*from_bytes(c, where="x.npz")), extractor, "x.npz")
    table = table_to_bytes(count_list(["truck tire", "truck trailer", "dog"]))
    telling = {"where": "t.npz", "fix": "count again"}
    for _, content in damaged(table, 500, seed=3):
        outcome(lambda c=content: table_to_bytes(table_from_bytes(c, **telling)), table, "t.npz")


def test_changes_by_hand_are_accepted_by_a_command(corpus, tmp_path, capsys):
    folder = tmp_path / "c"
    write_corpus(corpus, folder)
    path = folder / "commands.jsonl"
    before = path.read_text()
    path.write_text(before.replace('"subject":"0', '"subject":"1', 1))
    assert path.read_text() != before
    assert run(["corpus", "validate", str(folder)]) == 2
    assert f"{path}: the content is not what was written" in capsys.readouterr().out
    assert run(["corpus", "seal", str(folder)]) == 0
    assert "its hash is the same" in capsys.readouterr().out
    assert run(["corpus", "validate", str(folder)]) == 0
    path.write_text(path.read_text()[:-5])
    manifest = (folder / MANIFEST).read_bytes()
    assert run(["corpus", "seal", str(folder)]) == 2
    assert (folder / MANIFEST).read_bytes() == manifest


def test_a_corpus_of_the_first_version_is_read_and_can_be_sealed(corpus, tmp_path):
    folder = tmp_path / "c"
    write_corpus(corpus, folder)
    text = (folder / MANIFEST).read_text()
    old = text[: text.index(',\n  "digests"')] + "\n}\n"
    (folder / MANIFEST).write_text(old.replace('"schema_version": 2', '"schema_version": 1'))
    assert corpus_files(load_corpus(folder)) == corpus_files(corpus)
    assert run(["corpus", "seal", str(folder)]) == 0
    assert (folder / MANIFEST).read_text() == text
    (folder / MANIFEST).write_text(text.replace('"schema_version": 2', '"schema_version": 1'))
    with pytest.raises(FormatError, match="digest differs"):
        load_corpus(folder)
