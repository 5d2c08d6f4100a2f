"""Alarms about what isn't there: the removals, the figures and the command."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from corpus_tools.corpus.corpus_writing import write_corpus
from corpus_tools.importers.authored.bundled import open_corpus
from eval.absence.absence_evidence import PRESENT, AbsenceEvidence, any_nouns, without
from eval.absence.absence_report import figures, render
from eval.cli.eval_commands import evaluate
from tests.eval.yard import yards


def test_a_world_without_labels_keeps_its_robot():
    context = open_corpus("warehouse").contexts["dock_pick_up_tires"]
    left = without(context, ("pallet", "forklift"))
    assert left.agent is not None
    assert not any("pallet" in o.labels for o in left.objects)
    assert len(left.objects) < len(context.objects)


def test_figures_are_shares_below_a_threshold():
    evidence = AbsenceEvidence("c", (1.0, 0.2, PRESENT, 1.0), (0.1, 0.3, 1.0), (0.0, 0.5), ())
    found = figures(evidence, 0.25)
    assert found["threshold"] == found["false_alarms"] == 0.25
    assert found["seen_removed"] == pytest.approx(1 / 3)
    assert found["seen_any_noun"] == 0.5
    assert {found[name] for name in found if name.endswith("_reason")} == {""}


def test_without_commands_there_are_no_shares():
    nothing = AbsenceEvidence("c", (), (), (), ())
    assert figures(nothing, 0.25)["false_alarms_reason"] == "no data"
    assert figures(nothing)["threshold_reason"] == "no data"
    assert np.isnan(figures(nothing)["threshold"])
    assert "nan" not in render([nothing], "text", {})
    json.loads(render([nothing], "json", {}), parse_constant=pytest.fail)


def test_the_threshold_for_a_share_of_false_alarms_is_the_largest():
    own = tuple(0.1 * (1 + i // 5) for i in range(40))  # 0.1 five times, 0.2 five times ...
    found = figures(AbsenceEvidence("c", (*own, *[PRESENT] * 60), (0.15, 0.25), (), ()))
    # Five of a hundred are below 0.2, ten below 0.3.
    assert found["threshold"] == pytest.approx(0.2)
    assert (found["false_alarms"], found["seen_removed"]) == (0.05, 0.5)


def test_nouns_of_wordnet_name_things():
    nouns = any_nouns()
    assert {"horse", "car", "house"} <= set(nouns)
    assert not {"thing", "area", "idea", "minute"} & set(nouns)


def test_the_command_counts_alarms_in_each_corpus(tmp_path):
    write_corpus(yards(tmp_path / "made"), tmp_path / "yards")
    done = CliRunner().invoke(evaluate, ["--absent", "--corpus", str(tmp_path / "yards"), "--json"])
    assert done.exit_code == 0, done.output
    (row,) = json.loads(done.stdout)["rows"]
    assert row["commands"] > 0
    assert row["removals"] > 0
    for which in ("shipped", "at_5_percent"):
        assert all(0 <= row[which][name] <= 1 for name in ("false_alarms", "seen_removed"))
    assert row["shipped"]["seen_any_noun"] > 0.5
    assert row["at_5_percent"]["false_alarms"] <= 0.05
