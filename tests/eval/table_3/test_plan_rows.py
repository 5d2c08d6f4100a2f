"""Rows of Table 3, worked by hand."""

import math
from dataclasses import replace

import pytest

from eval.table_3.end_to_end import EndToEnd
from eval.table_3.judged_commands import Facts
from eval.table_3.outcomes import Outcome
from eval.table_3.plan_report import render, table
from eval.table_3.plan_rows import ALONE, COLUMNS, comparisons, followed, rows
from g3.errors import CorpusError

FACTS = {
    "a": Facts("ann", 0.5, is_determined=True, has_choice=True),
    "b": Facts("bob", 0.25, is_determined=False, has_choice=True),
    "c": Facts("ann", 1.0, is_determined=True, has_choice=False),
    "d": Facts("bob", 0.0, is_determined=False, has_choice=False),
}
WORLDS = {"a": "w1", "b": "w1", "c": "w2", "d": "w3"}


def made(correct, theme, refused="", probability=None):
    return [
        Outcome(
            name,
            WORLDS[name],
            "Go.",
            (probability or {}).get(name, 0.5),
            name in correct,
            "",
            theme=name in theme,
            refused=name in refused,
        )
        for name in WORLDS
    ]


def by_name(found):
    return {(row["configuration"], row["subset"]): row for row in found}


def test_a_row_for_each_configuration_and_part():
    outcomes = {"auto": made("ac", "abc", refused="d"), "keywords": made("a", "a")}
    found = by_name(rows(outcomes, FACTS, {"embeddings": "needs it"}, draws=50, seed=0))
    assert all(set(row) == set(COLUMNS) for row in found.values())
    names = {name for name, _ in found}
    assert names == {"keywords", "embeddings", "auto-top30", "auto-all"}
    model = found["auto-all", "all"]
    assert (model["n"], model["precision"], model["theme"]) == (4, 0.5, 0.75)
    assert model["chance"] == pytest.approx((0.5 + 0.25 + 1.0 + 0.0) / 4)
    assert model["refusals"] == 1
    assert math.isnan(model["low"])  # three worlds tell too little
    assert model["two_way_low"] < 0.5 < model["two_way_high"]
    part = found["auto-all", "two-or-more"]
    assert (part["n"], part["precision"], part["theme"]) == (2, 0.5, 1.0)
    assert (part["chance"], part["refusals"]) == (0.375, 0)
    known = found["auto-all", "determined"]
    assert (known["n"], known["precision"], known["theme"]) == (2, 1.0, 1.0)
    gone = found["embeddings", "all"]
    assert (gone["n"], gone["note"]) == (0, "needs it")
    assert math.isnan(gone["precision"])


def test_the_most_probable_are_of_their_own_part(monkeypatch):
    monkeypatch.setattr("eval.table_3.plan_rows.ROWS", (("auto-top1", "auto", 1),))
    likely = {"a": 0.1, "b": 0.2, "c": 0.3, "d": 0.9}
    found = by_name(rows({"auto": made("b", "", probability=likely)}, FACTS, {}, draws=20, seed=0))
    assert found["auto-top1", "all"]["precision"] == 0.0
    assert found["auto-top1", "two-or-more"]["precision"] == 1.0


def test_several_headings_count_as_their_mean():
    east = [replace(o, heading="east") for o in made("ab", "abcd")]
    loads = [replace(o, heading="loads") for o in made("a", "ab", refused="d")]
    both = followed([*east, *loads])
    assert [f.verdicts["precision"] for f in both] == [1.0, 0.5, 0.0, 0.0]
    found = by_name(rows({"auto": [*east, *loads]}, FACTS, {}, draws=20, seed=0))
    row = found["auto-all", "all"]
    assert (row["n"], row["precision"], row["theme"]) == (4, 0.375, 0.75)
    assert row["refusals"] == 0.5


def test_people_that_nobody_knows_have_no_interval():
    unknown = {name: replace(f, person="") for name, f in FACTS.items()}
    (row, *_) = rows({"nearest": made("ab", "a")}, unknown, {}, draws=20, seed=0)
    assert math.isnan(row["two_way_low"])


def test_many_worlds_have_an_interval():
    outcomes = [
        Outcome(f"c{i}", f"w{i}", "Go.", 0.5, i % 3 == 0, "", theme=True) for i in range(12)
    ]
    (row, *_) = rows({"nearest": outcomes}, {}, {}, draws=200, seed=0)
    assert row["precision"] == pytest.approx(1 / 3)
    assert row["low"] < 1 / 3 < row["high"]


def test_what_was_picked_up_may_be_unknown():
    theme = [replace(o, theme=None) if o.command == "a" else o for o in made("a", "b")]
    (row, *_) = rows({"nearest": theme}, FACTS, {}, draws=20, seed=0)
    assert row["theme"] == pytest.approx(1 / 3)
    assert row["n"] == 4


def test_models_are_compared_with_baselines_and_not_these_with_each_other():
    outcomes = {
        "nearest": made("", ""),
        "keywords": made("ab", "ab"),
        "auto": made("abc", "a"),
    }
    found = comparisons(outcomes, FACTS, draws=20, seed=0)
    assert {(c.subset, c.verdict) for c in found} == {
        (subset, verdict)
        for subset in ("all", "determined", "two-or-more")
        for verdict in ("precision", "theme")
    }
    for part in found:
        assert {(c.one, c.other) for c in part.comparisons} == {
            ("nearest", "auto"),
            ("keywords", "auto"),
        }
    (whole,) = (c for c in found if (c.subset, c.verdict) == ("all", "precision"))
    assert [c.difference.value for c in whole.comparisons] == [-0.75, -0.25]
    assert all(c.adjusted_p >= c.p for c in whole.comparisons)


def test_no_model_is_shown_without_its_baselines():
    outcomes = {name: made("a", "a") for name in ALONE}
    whole = EndToEnd({**outcomes, "auto": made("ab", "ab")}, {}, FACTS)
    text = render(whole, "text", draws=20)
    for name in (*ALONE, "auto-all"):
        assert f"\n{name} " in text
    assert len(render(whole, "csv", draws=20).splitlines()) == 1 + 3 * (len(ALONE) + 2)
    assert render(whole, "latex", draws=20).count(r"\begin{tabular}") == 3
    del outcomes["keywords"]
    with pytest.raises(CorpusError, match="no rows of keywords"):
        table(EndToEnd({**outcomes, "auto": made("ab", "ab")}, {}, FACTS))
    lacking = {"keywords": "needs an extra"}
    text = render(EndToEnd({**outcomes, "auto": made("ab", "ab")}, {}, FACTS, lacking), "text")
    lines = [line for line in text.splitlines() if line.startswith("keywords")]
    assert len(lines) == 3  # one for each part
    assert all(line.endswith("needs an extra") for line in lines)


def test_a_text_fits_100_columns_and_shows_comparisons_on_request():
    outcomes = {name: made("ac", "abc") for name in ("random", "nearest", "keywords", "gold")}
    lacking = {"embeddings": "needs it"}
    result = EndToEnd(outcomes, {"table": 3, "judge": "automatic"}, FACTS, lacking)
    short, long = (render(result, "text", draws=20, verbose=on) for on in (False, True))
    assert max(map(len, [*short.splitlines(), *long.splitlines()])) <= 100
    assert "compared on" not in short
    assert "compared on" in long
