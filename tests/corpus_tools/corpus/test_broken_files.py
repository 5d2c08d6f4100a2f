"""Every way to break a corpus gives an error that names file, record, field and remedy."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_validation import validate
from g3.errors import FormatError


def edit(path: Path, change) -> None:
    """Change the records of a JSONL file."""
    records = [json.loads(line) for line in path.read_text().splitlines()]
    records = change(records) or records
    path.write_text("".join(json.dumps(record) + "\n" for record in records))


def set_value(*keys, value):
    def change(records):
        inner = records
        for key in keys[:-1]:
            inner = inner[key]
        inner[keys[-1]] = value

    return change


BROKEN = [
    # file, change, parts of the message
    (
        "annotations.jsonl",
        set_value(0, "sdcs", 0, "relation", 0, value=[1, "Pick"]),
        ["line 1 (s-01/positive)", "sdcs[0].relation[0]", "'Pick' doesn't stand at 1"],
    ),
    (
        "annotations.jsonl",
        set_value(0, "sdcs", 0, "landmark1", 0, "words", 0, value=[99, "it"]),
        ["sdcs[0].landmark1[0].words[0]"],
    ),
    (
        "annotations.jsonl",
        set_value(0, "groundings", value=[[], []]),
        ["line 1 (s-01/positive)", "groundings", "2 entries for 3 clauses"],
    ),
    ("annotations.jsonl", set_value(0, "correct", value=[True]), ["correct", "1 entries"]),
    ("annotations.jsonl", set_value(0, "command", value="s-99"), ["command", "'s-99'"]),
    ("annotations.jsonl", set_value(0, "context", value="moon"), ["context", "'moon'"]),
    (
        "annotations.jsonl",
        set_value(0, "groundings", 0, 0, value={"kind": "reference", "object": "nix"}),
        ["groundings[0][0]", "no object 'nix' in the context 'world'"],
    ),
    (
        "annotations.jsonl",
        set_value(0, "groundings", 1, value=[{"kind": "path", "trajectory": 7}]),
        ["groundings[1][0].trajectory", "no trajectory 7", "holds 2"],
    ),
    ("annotations.jsonl", set_value(0, "source", value="guess"), ["line 1", "source"]),
    ("annotations.jsonl", set_value(0, "sdcs", 0, "type", value="THING"), ["sdcs[0].type"]),
    ("annotations.jsonl", set_value(0, "colour", value="red"), ["line 1", "`colour`"]),
    ("contexts.jsonl", set_value(0, "agent_id", value="r2d2"), ["agent_id", "'r2d2'"]),
    (
        "contexts.jsonl",
        set_value(0, "objects", 1, "id", value="robot"),
        ["line 1 (world)", "objects[1].id", "'robot'"],
    ),
    (
        "contexts.jsonl",
        set_value(0, "objects", 1, "prism", "xy", value=[[0, 0], [1, 1]]),
        ["objects[1].prism", "at least 3 corners"],
    ),
    ("contexts.jsonl", set_value(0, "objects", 0, "prism", "z_max", value=-1), ["interval"]),
    (
        "contexts.jsonl",
        set_value(0, "places", 0, "prism", "z_min", value="low"),
        ["places[0].prism.z_min"],
    ),
    ("commands.jsonl", set_value(1, "id", value="s-01"), ["line 2", "'s-01'", "line 1"]),
    ("commands.jsonl", set_value(0, "text", value=None), ["line 1", "text", "expected `str`"]),
    ("judgments.jsonl", set_value(1, "rating", value="maybe"), ["line 2", "rating"]),
    ("judgments.jsonl", lambda records: records[:1], ["corpus.json", "counts.judgments", "2"]),
    ("commands.jsonl", set_value(1, "text", value="other"), ["commands.jsonl: ", "digest"]),
    ("commands.jsonl", set_value(1, "subject", value="x"), ["commands.jsonl: ", "digest differs"]),
    (
        "judgments.jsonl",
        set_value(1, "subject", value="x"),
        ["judgments.jsonl: ", "ct corpus"],
    ),
]


@pytest.mark.parametrize(("file", "change", "parts"), BROKEN)
def test_a_broken_record(corpus_path, file, change, parts):
    edit(corpus_path / file, change)
    with pytest.raises(FormatError) as caught:
        Corpus.load(corpus_path)
    message = str(caught.value)
    assert str(corpus_path) in message
    assert caught.value.fix
    for part in parts:
        assert part in message
    assert message in map(str, validate(corpus_path))


def test_a_file_that_is_cut_off(corpus_path):
    path = corpus_path / "annotations.jsonl"
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(FormatError, match=r"annotations.jsonl: line 1: the last line is cut off"):
        Corpus.load(corpus_path)


def test_bytes_that_are_not_text(corpus_path):
    path = corpus_path / "commands.jsonl"
    path.write_bytes(path.read_bytes().replace(b"Pick", b"Pi\xffk"))
    with pytest.raises(FormatError, match=r"commands.jsonl: line 1"):
        Corpus.load(corpus_path)


@pytest.mark.parametrize(
    "name",
    ["contexts.jsonl", "commands.jsonl", "annotations.jsonl", "judgments.jsonl",
     "trajectories.npz", "corpus.json"],
)  # fmt: skip
def test_a_missing_file(corpus_path, name):
    (corpus_path / name).unlink()
    with pytest.raises(FormatError, match=name):
        Corpus.load(corpus_path)


def change_arrays(path: Path, **changes) -> None:
    with np.load(path) as file:
        arrays = dict(file) | changes
    np.savez(path, **arrays)


def test_a_trajectory_that_is_not_a_number(corpus_path):
    path = corpus_path / "trajectories.npz"
    with np.load(path) as file:
        xyz = file["xyz"].copy()
    xyz[1, 1] = np.nan
    change_arrays(path, xyz=xyz)
    with pytest.raises(FormatError, match=r"contexts.jsonl: line 1 .*trajectory 0.*not finite"):
        Corpus.load(corpus_path)


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"t": np.zeros(2)}, "shapes"),
        ({"xyz": np.zeros((4, 2))}, "shapes"),
        ({"xyz": np.zeros(4)}, "xyz: .*expected <f8 with 2 dimensions"),
        ({"yaw": np.zeros(4, np.float32)}, "yaw: .*type <f4"),
        ({"offsets": np.array([0, 9])}, "offsets"),
        ({"offsets": np.array([0, 3, 1, 4])}, "offsets"),
        ({"t": np.array([None, 1, 2, 3], dtype=object)}, "the type .O"),
    ],
)
def test_trajectories_of_the_wrong_form(corpus_path, changes, what):
    change_arrays(corpus_path / "trajectories.npz", **changes)
    with pytest.raises(FormatError, match=rf"trajectories.npz.*{what}"):
        Corpus.load(corpus_path)


def test_trajectories_that_are_cut_off(corpus_path):
    path = corpus_path / "trajectories.npz"
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(FormatError, match=r"trajectories.npz.*can't be read"):
        Corpus.load(corpus_path)


@pytest.mark.parametrize(
    ("content", "what"),
    [
        ("{", "malformed|truncated"),
        ("[]", "expected `object`"),
        ("{}", "version is none"),
        ('{"schema_version": 99}', "version is 99, this program reads 1 and 2"),
        ('{"schema_version": 1}', "missing required field"),
    ],
)
def test_a_broken_manifest(corpus_path, content, what):
    (corpus_path / "corpus.json").write_text(content)
    with pytest.raises(FormatError, match=rf"corpus.json.*({what})"):
        Corpus.load(corpus_path)


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(FormatError, match=r"no such folder.*ct import"):
        Corpus.load(tmp_path / "nowhere")


def test_a_folder_that_is_no_corpus(tmp_path):
    with pytest.raises(FormatError, match=r"not a corpus"):
        Corpus.load(tmp_path)


def test_validation_lists_every_problem(corpus_path):
    edit(corpus_path / "commands.jsonl", set_value(1, "text", value=3))
    edit(
        corpus_path / "contexts.jsonl", set_value(0, "places", 0, "prism", "xy", value=[[0, 0]] * 3)
    )
    edit(corpus_path / "annotations.jsonl", set_value(0, "sdcs", 0, "words", value=[[5, "it"]]))
    edit(corpus_path / "judgments.jsonl", set_value(0, "shown_video", value=""))
    text = "\n".join(map(str, validate(corpus_path)))
    assert "commands.jsonl: line 2: text" in text
    assert "contexts.jsonl: world: places[0]: prism.xy: the footprint has no area" in text
    assert "annotations.jsonl: s-01/positive: sdcs[0]: the figure holds words" in text
    assert "judgments.jsonl: j1: shown_video: the value is empty" in text
    assert "corpus.json: hash" in text
