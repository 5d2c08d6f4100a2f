"""The catalogue of potentials: each can be listed, switched off and added to."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from corpus_tools.corpus.annotated_trees import annotated_commands
from corpus_tools.importers.authored.bundled import open_corpus
from g3.errors import ModelError
from g3.features.feature_registry import catalogue
from g3.inference.grounder import Grounder
from g3.inference.potentials.potential_registry import (
    KINDS,
    ablation,
    check_potentials,
    heard,
    potential,
    potentials,
)
from g3.inference.problem.scoring import Scorer
from g3.sdc.clauses import SDC_TYPES
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.inference.constant_cost import ConstantCost

PYTHON = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
RULES = {rule.name: rule for rule in potentials()}
COMMANDS = list(annotated_commands(open_corpus("warehouse").annotations).values())[::23]


@pytest.mark.parametrize("rule", potentials(), ids=lambda rule: rule.name)
def test_every_potential_says_what_it_is(rule):
    assert rule.description.endswith(".")
    assert len(rule.description) < 100
    assert rule.kind in KINDS
    assert rule.types
    assert set(rule.types) <= set(SDC_TYPES)
    assert rule.weight < 0 or rule.kind == "referent"
    assert rule.name == rule.name.lower()


def test_names_are_those_of_no_feature_set():
    assert len(RULES) > 40
    assert not RULES.keys() & {feature.name for feature in catalogue()}
    for taken in ("side", "labels"):
        with pytest.raises(ValueError, match="already"):
            potential(taken, kind="spot", types=("PLACE",), weight=-1.0)(len)


def test_names_are_told_apart():
    found = ablation(["labels", "side"])
    assert (found.sets, found.potentials) == ({"labels"}, {"side"})
    for check in (ablation, check_potentials):
        with pytest.raises(ModelError, match="told-sid") as error:
            check(["side", "told-sid"])
        assert "did you mean 'told-side'?" in error.value.fix
    with pytest.raises(ModelError, match="labels"):
        Grounder(ConstantCost(), without=["labels"])


def told(result):
    """What came of a command, to compare."""
    return [(plan.score, plan.actions, plan.evidence) for plan in result.plans], result.note


def followed(model, annotation, without=()):
    """What comes of a command, and which potentials say something on the way."""
    grounder = Grounder(Scorer(model), without=without)
    with heard() as spoke:
        result = grounder.follow(annotation.sdcs, annotation.context, least=0.0, top=3)
    return told(result), spoke


@settings(max_examples=12)
@given(st.sampled_from(COMMANDS), st.data())
def test_without_what_says_nothing_nothing_changes(model, annotation, data):
    whole, spoke = followed(model, annotation)
    silent = data.draw(st.sets(st.sampled_from(sorted(set(RULES) - spoke)), min_size=5))
    assert followed(model, annotation, silent)[0] == whole


@pytest.mark.parametrize(
    ("notation", "rule"),
    [
        ("EVENT(r = Turn left)", "way"),
        ("EVENT(r = Pick up, l = OBJ(f = the tires))", "verb-take"),
    ],
)
def test_what_is_switched_off_adds_nothing(notation, rule, model, dock):
    def spoken(without):
        problem = Grounder(Scorer(model), without=without)
        plans = problem.follow(parse_brackets(notation), dock, explain=True, top=8, least=0.0).plans
        reasons = {r.feature for plan in plans for g in plan.groundings for r in g.reasons}
        return [plan.score for plan in plans], reasons

    before, reasons = spoken(())
    after, others = spoken((rule,))
    assert before != after
    assert f"besides/{rule}" not in others
    assert f"besides/{rule}" in reasons


def test_a_refusal_can_be_switched_off(model):
    loaded = open_corpus("warehouse").contexts["depot_go_to_receiving_loaded"]
    lift = parse_brackets("EVENT(r = Lift, l = OBJ(f = the tires))")
    assert "on the forks" in Grounder(Scorer(model)).follow(lift, loaded).note
    off = Grounder(Scorer(model), without=("load-in-the-way",))
    with heard() as whole:
        Grounder(Scorer(model)).follow(lift, loaded)
        with heard() as within:
            assert "on the forks" not in off.follow(lift, loaded, least=0.0).note
    assert whole == {"load-in-the-way"}
    assert whole.isdisjoint(within)


PAGE = Path(__file__).parents[3] / "docs" / "contributing" / "potentials.md"
FOLLOW = """
import sys
from corpus_tools.importers.authored.bundled import open_corpus
from tests.g3.inference.constant_cost import ConstantCost
from g3.inference.grounder import Grounder
from g3.sdc.sdc_notation import parse_brackets

context = open_corpus("warehouse").contexts["court_put_crate_on_trailer"]
go = parse_brackets("EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the trailer)))")
result = Grounder(ConstantCost(), without=sys.argv[1:]).follow(go, context, least=0.0)
print(result.plan.actions[0].kind if result.plan else result.note)
"""


def test_other_distributions_add_potentials(tmp_path):
    info = tmp_path / "own_rules-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: own-rules\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[g3.potentials]\nown = own_rules\n")
    # The docs show how.
    (code,) = (c for c in PYTHON.findall(PAGE.read_text()) if "@potential" in c)
    (tmp_path / "own_rules.py").write_text(code)
    paths = os.pathsep.join([str(tmp_path), str(Path.cwd())])

    def run(*command):
        done = subprocess.run(
            [sys.executable, *command],
            check=True,
            capture_output=True,
            text=True,
            env={**os.environ, "PYTHONPATH": paths},
        )
        return done.stdout

    listed = json.loads(run("-m", "corpus_tools", "features", "list", "--json"))
    (own,) = (rule for rule in listed["potentials"] if rule["name"] == "no-driving")
    assert (own["description"], own["hard"]) == ("The robot doesn't drive.", True)
    assert not run("-c", FOLLOW).startswith("drive")
    assert run("-c", FOLLOW, "no-driving") == "drive to\n"
