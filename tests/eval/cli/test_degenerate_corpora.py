"""``ct eval`` on corpora whose ratings or annotations show nothing: reasons, or a named error."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from dataclasses import replace

import pytest

from corpus_tools.cli.console import run
from corpus_tools.corpus.estimate import REASONS
from g3.annotation import Judgment
from tests.shared_cases import case
from tests.tiny_corpus import SCENARIOS, tiny_corpus

FORMATS = ("text", "json", "csv", "latex")


def rated(*rows, raters=3, commands=8):
    """Judgments of commands with their own and with another video, as `rows` say of each.

    A row is a rater's two ratings, or those of several raters in turn.
    """
    own = list(tiny_corpus().commands.values())[:commands]
    videos = list(dict.fromkeys(command.video for command in own))
    found = []
    for number, command in enumerate(own):
        other = videos[(videos.index(command.video) + 1) % len(videos)]
        for rater in range(raters):
            pair = rows[(number + rater) % len(rows)]
            for shown, rating in zip((command.video, other), pair, strict=True):
                about = (command.text, command.video, shown, rating, f"r{rater}", "study")
                found.append(Judgment(f"{len(found):03}", *about))
    return found


DEGENERATE = {
    "separated": rated(("SA", "SD"), ("A", "D")),
    "quasi-separated": rated(("SA", "N"), ("N", "SD"), ("A", "D"), ("A", "N")),
    "constant": rated(("N", "N")),
    "everybody agrees": rated(("A", "A"), ("SA", "SA")),
    "nobody agrees": rated(("D", "SD")),
    "raters agree": [
        replace(j, rating=("A", "D", "SA")[len(j.command) % 3]) for j in rated(("A", "D"))
    ],
    "one rater": rated(("SA", "SD"), ("D", "A"), ("N", "N"), raters=1),
    "one rater who always says three": rated(("N", "N"), raters=1),
    "one command": rated(("SA", "SD"), ("D", "A"), raters=4, commands=1),
    "twelve judgments": rated(("A", "D"), ("D", "A"), raters=2, commands=3),
    "one judgment": rated(("SA", "SD"))[:1],
    "own videos only": [
        j for j in rated(("A", "D"), ("D", "A")) if j.command_video == j.shown_video
    ],
    "everybody rated something else": [
        replace(j, subject=f"p{i}") for i, j in enumerate(rated(("A", "D"), ("D", "A"), raters=1))
    ],
    "nobody is named": [replace(j, subject="") for j in rated(("A", "D"), ("D", "A"))],
}  # fmt: skip


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """A corpus of each kind, with worlds and logs."""
    folder = tmp_path_factory.mktemp("degenerate")
    for name, judgments in DEGENERATE.items():
        replace(tiny_corpus(), judgments=tuple(judgments)).save(folder / name)
    return folder


@pytest.fixture
def output(capsys):
    def output(*arguments):
        status = run(["eval", *map(str, arguments)])
        printed = capsys.readouterr()
        assert status == 0, printed.err
        assert printed.err == ""
        return printed.out

    return output


def refuse(constant):
    raise AssertionError(f"{constant} is no JSON")


def strict(text):
    return json.loads(text, parse_constant=refuse)


def reasons(found: object) -> Iterator[str]:
    """All reasons in a document; a missing value must have one beside it."""
    if isinstance(found, dict):
        is_estimate = {"low", "high"} <= found.keys()
        for key, value in found.items():
            if key.endswith("_reason") or (key == "reason" and is_estimate):
                assert value in {"", *REASONS}
                yield value
            yield from reasons(value)
        if is_estimate:
            assert (found["low"] is None) == (found["high"] is None) == bool(found["reason"])
    elif isinstance(found, list):
        for one in found:
            yield from reasons(one)


@pytest.mark.parametrize("name", DEGENERATE)
def test_ratings_that_show_nothing_have_reasons(name, folders, output):
    document = strict(output("--table", "2", "--models", "--corpus", folders / name, "--json"))
    named = {*reasons(document)} - {""}
    assert named
    odds = document["odds_ratio"]
    assert (odds["value"] is None) or (odds["value"] < 1e6 and odds["reason"] == "few clusters")
    for form in ("text", "csv", "latex"):
        text = output("--table", "2", "--models", "--corpus", folders / name, "--format", form)
        words = text.replace("null", "").casefold()
        assert not {"nan", "inf"} & {*words.replace(",", " ").replace("(", " ").split()}
        # CSV and LaTeX name what they have figures of; text has all.
        assert all(reason in text for reason in named) or form != "text"
        assert any(reason in text for reason in named)
        if form == "csv":
            (*_, row) = csv.DictReader(io.StringIO(text))
            assert (row["odds_ratio_reason"], row["alpha_reason"]) == (
                odds["reason"], document["alpha_reason"],
            )  # fmt: skip


def test_odds_of_separated_ratings_are_not_printed(folders, output):
    for name in ("separated", "quasi-separated"):
        text = output("--table", "2", "--models", "--corpus", folders / name)
        assert "against the random one: none (separated)" in text


@pytest.mark.parametrize("name", DEGENERATE)
def test_plans_are_of_the_corpus_or_have_a_reason(name, folders, output):
    document = strict(output("--power", "--corpus", folders / name, "--json"))
    own = [j for j in DEGENERATE[name] if j.command_video == j.shown_video]
    agree = sum(j.rating in ("A", "SA") for j in own) / len(own)
    assert document["share"] == pytest.approx(agree, abs=5e-4)
    for row in document["rows"]:
        assert (row["pairs"] is None) == (row["reason"] != "")
        assert row["pairs"] is None or 0 < agree < 1
    for form in ("text", "csv", "latex"):
        text = output("--power", "--corpus", folders / name, "--format", form)
        assert all(row["reason"] in text for row in document["rows"])


def test_raters_who_agree_plan_for_pairs_alone(folders, output):
    """All of a pair say the same, so that more judges of it say no more."""
    document = strict(output("--power", "--corpus", folders / "raters agree", "--json"))
    assert document["correlation"] == 1.0
    assert len({row["pairs"] for row in document["rows"]}) == 1
    assert [row["design_effect"] for row in document["rows"]] == [1, 3, 5, 10]


@pytest.mark.parametrize("name", DEGENERATE)
def test_the_judge_is_compared_or_there_is_a_reason(name, folders, output):
    document = strict(output("--judge-validity", "--corpus", folders / name, "--json"))
    assert {*reasons(document)} - {""}
    assert "nan" not in output("--judge-validity", "--corpus", folders / name)


def test_a_corpus_without_judgments_has_no_plan(tmp_path, output, capsys):
    tiny_corpus().save(tmp_path / "tiny")
    document = strict(output("--power", "--corpus", tmp_path / "tiny", "--json"))
    assert (document["share"], document["share_reason"]) == (None, "no data")
    assert {row["reason"] for row in document["rows"]} == {"no data"}
    assert run(["eval", "--table", "2", "--corpus", str(tmp_path / "tiny")]) == 2
    assert "no judgments" in capsys.readouterr().err


@pytest.mark.parametrize("source", ["positive", "random"])
def test_a_class_without_examples_has_reasons(source, tmp_path, output):
    """All that is annotated is right, or nothing is."""
    whole = tiny_corpus(SCENARIOS[:2])
    some = tuple(a for a in whole.annotations if a.source == source)
    replace(whole, annotations=some).save(tmp_path / "some")
    options = ("--table", "1", "--cv", "scenario", "--corpus", tmp_path / "some")
    document = strict(output(*options, "--json"))
    assert {*reasons(document)} >= {"empty class", "few clusters"}
    for form in FORMATS:
        text = output(*options, "--format", form)
        assert "empty class" in text
        assert "nan" not in text.casefold()


def test_one_scenario_is_refused_by_name(tmp_path, capsys):
    tiny_corpus(SCENARIOS[:1]).save(tmp_path / "one")
    for options in (("--table", "1"), ("--errors",), ("--sdc",)):
        arguments = ["eval", *options, "--cv", "scenario", "--corpus", str(tmp_path / "one")]
        assert run(arguments) == 2
        assert "no examples to train on" in capsys.readouterr().err


def test_people_who_are_not_named_are_no_single_person(folders, output):
    document = strict(output("--table", "2", "--corpus", folders / "nobody is named", "--json"))
    for row in document["rows"]:
        assert row["two_way"]["reason"] == row["weighed_reason"] == "unknown people"


def test_twelve_judgments(output):
    """A study of two people who rated six pairs each."""
    folder = case("16-eval-degenerate") / "tiny-corpus"
    document = strict(output("--table", "2", "--models", "--corpus", folder, "--json"))
    assert [row["n"] for row in document["rows"]] == [6, 6]
    assert {row["weighed_reason"] for row in document["rows"]} == {"few raters"}
    assert document["odds_ratio"]["reason"] == "few clusters"
    document = strict(output("--power", "--corpus", folder, "--json"))
    assert (document["share"], document["correlation"]) == (0.333, 1.0)
    assert {row["pairs"] for row in document["rows"]} == {949}
