"""What was done: records, what contradicts itself, whose it is, and several corpora as one."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_validation import seal, validate
from corpus_tools.corpus.start_headings import parse_heading, with_headings
from corpus_tools.corpus.task_outcomes import contexts_of_commands, is_drive, outcomes_of
from g3.annotation import Command, TaskOutcome
from g3.errors import CorpusError, FormatError
from g3.groundings import Trajectory

STACKED = TaskOutcome("o1", "s", "world", picked=("p1",), put="on", on=("p2",), log="done")
"""One pallet was put on the other."""


def with_outcomes(corpus, *outcomes):
    return replace(corpus, outcomes=outcomes)


def test_a_corpus_without_outcomes_is_written_as_ever(small_corpus):
    files = small_corpus.files()
    assert "outcomes.jsonl" not in files
    assert b"outcomes" not in files["corpus.json"]
    assert b"assumed" not in files["contexts.jsonl"]


def test_a_record_says_no_more_than_is_known(small_corpus):
    files = with_outcomes(small_corpus, STACKED).files()
    assert json.loads(files["outcomes.jsonl"]) == {
        "id": "o1", "scenario": "s", "context": "world",
        "picked": ["p1"], "put": "on", "on": ["p2"], "log": "done",
    }  # fmt: skip
    assert json.loads(files["corpus.json"])["counts"]["outcomes"] == 1


def test_the_hash_sees_outcomes(small_corpus):
    other = replace(STACKED, put="ground", on=())
    hashes = {with_outcomes(small_corpus, o).hash for o in (STACKED, other)}
    assert len({*hashes, small_corpus.hash}) == 3


@pytest.mark.parametrize(
    ("fields", "parts"),
    [
        ({"context": "moon"}, ["context", "no context 'moon'"]),
        ({"command": "s-99"}, ["command", "no command 's-99'"]),
        ({"command": "s-01", "scenario": "t"}, ["scenario", "'s', not 't'"]),
        ({"picked": ("nix",)}, ["picked[0]", "no thing 'nix' in the context 'world'"]),
        ({"picked": ("robot",)}, ["picked[0]", "no thing 'robot'"]),
        ({"on": ("p2", "nix"), "unknown": ("on",)}, ["on[1]", "'nix'"]),
        ({"picked": ()}, ["put", "nothing was picked up"]),
        ({"unknown": ("put",)}, ["put", "also that it is unknown"]),
        ({"put": "ground"}, ["on", "while 'put' is 'ground'"]),
        ({"on": ()}, ["on", "0 things to be put on"]),
        ({"on": ("p1",)}, ["on", "put on itself"]),
        ({"unknown": ("rest", "rest")}, ["unknown", "twice"]),
        ({"unknown": ("why",)}, ["unknown[0]"]),
        ({"put": "down"}, ["put"]),
        ({"checkpoint": "7"}, ["checkpoint"]),
    ],
)
def test_what_contradicts_itself(small_corpus, tmp_path, fields, parts):
    with_outcomes(small_corpus, replace(STACKED, **fields)).save(tmp_path / "c")
    with pytest.raises(FormatError) as caught:
        Corpus.load(tmp_path / "c")
    for part in ["outcomes.jsonl: line 1", *parts]:
        assert part in str(caught.value)
    assert str(caught.value) in map(str, validate(tmp_path / "c"))


def test_what_is_unknown_may_be_left_open(small_corpus, tmp_path):
    corpus = with_outcomes(
        small_corpus,
        replace(STACKED, picked=(), unknown=("picked",)),
        replace(STACKED, id="o2", on=(), unknown=("on",)),
        replace(STACKED, id="o3", picked=(), put="", on=(), unknown=("picked", "put", "place")),
        replace(STACKED, id="o4", picked=(), put="", on=(), checkpoint=3, unknown=("place",)),
    )
    corpus.save(tmp_path / "c")
    assert validate(tmp_path / "c") == []
    loaded = Corpus.load(tmp_path / "c")
    assert loaded == corpus
    assert [is_drive(outcome) for outcome in loaded.outcomes] == [False, False, False, True]


def test_a_file_that_is_lost_changed_or_added(small_corpus, tmp_path):
    path = tmp_path / "c"
    with_outcomes(small_corpus, STACKED).save(path)
    file = path / "outcomes.jsonl"
    file.write_text(file.read_text().replace("done", "undone"))
    with pytest.raises(FormatError, match=r"outcomes.jsonl: .*digest"):
        Corpus.load(path)
    seal(path)
    assert Corpus.load(path).outcomes[0].log == "undone"
    content = file.read_bytes()
    file.unlink()
    with pytest.raises(FormatError, match=r"outcomes.jsonl: the file can't be read"):
        Corpus.load(path)
    plain = tmp_path / "plain"
    small_corpus.save(plain)
    (plain / "outcomes.jsonl").write_bytes(content)
    with pytest.raises(FormatError, match=r"0 outcomes are promised, 1 are there"):
        Corpus.load(plain)
    seal(plain)
    assert len(Corpus.load(plain).outcomes) == 1


def test_an_assumption_about_nothing(small_corpus, tmp_path):
    context = replace(small_corpus.contexts["world"], assumed=(("nix", "size"),))
    replace(small_corpus, contexts={"world": context}).save(tmp_path / "c")
    with pytest.raises(FormatError, match=r"assumed\[0\]: no object has the id 'nix'"):
        Corpus.load(tmp_path / "c")


def test_whose_outcome_it_is(small_corpus):
    commands = [*small_corpus.commands.values(), Command("s-03", "Go", "s", "v2")]
    small_corpus = replace(small_corpus, commands={c.id: c for c in commands})
    own = replace(STACKED, id="own", command="s-02")
    of_v1 = replace(STACKED, id="v1", video="v1")
    of_all = replace(STACKED, id="all")
    other = replace(STACKED, id="other", scenario="t")
    corpus = with_outcomes(small_corpus, own, of_v1, of_all, other)
    found = {c.id: [o.id for o in outcomes_of(corpus, c)] for c in commands}
    assert found == {"s-01": ["v1", "all"], "s-02": ["own"], "s-03": ["all"]}


def test_the_context_of_each_command(small_corpus):
    s2, named, lost = (Command(f"c{i}", "Go", s) for i, s in enumerate(["told", "world", "lost"]))
    commands = {**small_corpus.commands, **{c.id: c for c in (s2, named, lost)}}
    corpus = replace(small_corpus, commands=commands, outcomes=(replace(STACKED, scenario="told"),))
    # s-01 is annotated, s-02 is of its scenario, c0 has an outcome, c1 the context's name.
    assert contexts_of_commands(corpus) == dict.fromkeys(["s-01", "s-02", "c0", "c1"], "world")


def test_annotations_follow_a_turned_robot(small_corpus):
    world = small_corpus.contexts["world"]
    robot = world.agent
    still = replace(robot, trajectory=Trajectory(robot.trajectory.t[:1], [[0.5, 0.5, 0]], [0.0]))
    context = replace(
        world,
        objects=tuple(still if o is robot else o for o in world.objects),
        assumed=(("robot", "heading"),),
    )
    (annotation,) = small_corpus.annotations
    annotation = replace(
        annotation, context=context, groundings=((still,), *annotation.groundings[1:])
    )
    corpus = Corpus.build(
        "c",
        contexts=[context],
        commands=small_corpus.commands.values(),
        annotations=[annotation],
        outcomes=[STACKED],
    )
    turned = with_headings(corpus, parse_heading("90"))
    agent = turned.contexts["world"].agent
    assert turned.annotations[0].groundings[0][0] is agent
    assert turned.annotations[0].context is turned.contexts["world"]
    # The square from (0, 0) to (1, 1) around (0.5, 0.5) turned by 90°: corner by corner.
    expected = [[1, 0], [1, 1], [0, 1], [0, 0]]
    assert abs(agent.prism.xy - expected).max() < 1e-9
    assert turned.outcomes == (STACKED,)


def test_a_recorded_heading_and_a_moving_robot_stay(small_corpus):
    assert with_headings(small_corpus, parse_heading("90")) is small_corpus
    context = replace(small_corpus.contexts["world"], assumed=(("robot", "heading"),))
    moving = replace(small_corpus, contexts={"world": context})
    assert with_headings(moving, parse_heading("90")) is moving


def test_several_corpora_as_one(small_corpus):
    one = with_outcomes(small_corpus, STACKED)
    contexts = [replace(c, id="other") for c in one.contexts.values()]
    two = Corpus.build(
        "two",
        contexts=contexts,
        commands=[Command("t-01", "Go", "t")],
        annotations=(),
        outcomes=[replace(STACKED, id="o2", scenario="t", context="other")],
        source="elsewhere",
    )
    both = Corpus.merge("both", [one, two])
    assert [o.id for o in both.outcomes] == ["o1", "o2"]
    assert list(both.contexts) == ["world", "other"]
    assert both.annotations == one.annotations
    assert both.judgments == one.judgments
    assert both.source == "made up; elsewhere"
    with pytest.raises(CorpusError, match="two of the corpora have the context 'world'"):
        Corpus.merge("both", [one, one])
