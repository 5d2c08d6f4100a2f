from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eval.splits import hold_out, leave_one_out, read_scenarios
from g3.errors import CorpusError

names = st.sampled_from(["a", "b", "c", "d", "e"])
several = st.lists(names, min_size=2, max_size=40).filter(lambda s: len(set(s)) > 1)


def sides(split, scenarios):
    return {scenarios[i] for i in split.train}, {scenarios[i] for i in split.test}


@given(several)
def test_leaving_one_out_tests_every_example_once(scenarios):
    splits = leave_one_out(scenarios)
    tested = np.concatenate([split.test for split in splits])
    assert sorted(tested.tolist()) == list(range(len(scenarios)))
    for split in splits:
        assert sides(split, scenarios) == (set(scenarios) - {split.name}, {split.name})
        assert sorted([*split.train, *split.test]) == list(range(len(scenarios)))


@given(several, st.data())
def test_held_out_scenarios_are_never_trained_on(scenarios, data):
    known = sorted(set(scenarios))
    held_out = data.draw(
        st.lists(st.sampled_from(known), min_size=1, max_size=len(known) - 1, unique=True)
    )
    split = hold_out(scenarios, held_out)
    assert sides(split, scenarios) == (set(known) - set(held_out), set(held_out))
    assert len(split.train) + len(split.test) == len(scenarios)


@pytest.mark.parametrize(
    ("scenarios", "held_out", "side"),
    [(["a", "a"], ["a"], "train on"), (["a", "b"], ["c"], "test on"), ([], ["a"], "train on")],
)
def test_an_empty_side_is_refused(scenarios, held_out, side):
    with pytest.raises(CorpusError, match=f"there are no examples to {side}"):
        hold_out(scenarios, held_out)


def test_a_single_scenario_cannot_be_left_out():
    with pytest.raises(CorpusError, match="split a: there are no examples to train on"):
        leave_one_out(["a", "a"])


def test_scenarios_are_read_from_the_command_line_or_a_file(tmp_path):
    known = ["a", "b", "c"]
    assert read_scenarios("b, a,", known) == ("a", "b")
    listed = tmp_path / "list.txt"
    listed.write_text("# of the test\nc\n\n a # the first\nc\n")
    assert read_scenarios(str(listed), known) == ("a", "c")


def test_a_scenario_goes_before_a_file_of_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a").write_text("b")
    assert read_scenarios("a", ["a", "b"]) == ("a",)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("a,x", "--test-scenarios: there is no scenario 'x' .give one of a, b"),
        (",", "no scenario is named"),
        ("x" * 5000, "there is no scenario 'xxx"),
        ("a\0", "there is no scenario"),
    ],
)
def test_unknown_scenarios_are_refused(given, message):
    with pytest.raises(CorpusError, match=message):
        read_scenarios(given, ["b", "a"])


def test_bad_files_are_refused(tmp_path):
    path = tmp_path / "list"
    path.write_text("x\n")
    with pytest.raises(CorpusError, match=r"list: there is no scenario 'x'"):
        read_scenarios(str(path), ["a"])
    path.write_bytes(b"a\n\xff")
    with pytest.raises(CorpusError, match=r"list:2:1: byte 3 is not UTF-8"):
        read_scenarios(str(path), ["a"])
