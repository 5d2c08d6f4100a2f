"""Grounders and parsers that are registered by other modules, as rows of Table 3."""

import json
import pickle

import pytest
from click.testing import CliRunner

from eval.cli.eval_commands import evaluate
from eval.judging.judge_registry import judge_named, plan_judge
from eval.parsing.parser_registry import PARSERS, parser
from eval.table_3.end_to_end import run
from eval.table_3.grounder_registry import GROUNDERS, Proposal, grounder, grounder_named
from eval.table_3.plan_rows import rows
from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import PICK_UP
from g3.errors import CorpusError
from g3.sdc.sdc_notation import parse_brackets
from tests.eval.yard import few_annotated

FRIDGE, WASHER = "11", "12"


@pytest.fixture
def registered():
    """What a test registers is gone after it."""
    known = GROUNDERS, PARSERS
    before = [set(registry) for registry in known]
    yield
    for registry, kept in zip(known, before, strict=True):
        for name in set(registry) - kept:
            registry.remove(name)


def follow(folders, name, **options):
    result = run(*folders, configurations=("nearest",), grounders=[grounder_named(name)], **options)
    return {o.text: o for o in result.outcomes.get(name, ())}, result


def test_who_learns_never_sees_the_scenario_that_is_tested(folders, registered):
    seen = {}

    def learn(annotations):
        return sorted({a.command.scenario for a in annotations})

    @grounder("learner", fit=learn)
    def learner(task, learned):
        """Note what was learned from."""
        seen[task.scenario] = learned
        return [Action(PICK_UP, task.loads[0].id)]

    few = folders[0]
    outcomes, _ = follow((few, few), "learner")
    assert len(outcomes) == len(seen) == 2
    for scenario, learned in seen.items():
        assert learned == sorted(seen.keys() - {scenario})


def test_a_task_holds_nothing_of_what_was_done(folders, registered):
    tasks = []

    @grounder("looker")
    def looker(task):
        """Look."""
        tasks.append(task)
        return []

    outcomes, _ = follow((folders[0], folders[0]), "looker")
    for task in tasks:
        for thing in task.start.context.objects:
            assert len(thing.trajectory) == 1
    assert all(o.refused and o.reason == "no plan was made" for o in outcomes.values())


def test_plans_that_cannot_be_carried_out_are_refused(folders, registered):
    @grounder("greedy")
    def greedy(task):
        """Pick up all loads."""
        return Proposal([Action(PICK_UP, load.id) for load in task.loads], 0.9)

    outcomes, _ = follow(folders, "greedy")
    assert outcomes["Pick up the pallet."].correct  # there is one
    assert outcomes["Pick up the pallet."].probability == 0.9
    both = outcomes["Pick up the refrigerator."]
    assert (both.refused, both.probability) == (True, 0.0)
    assert both.reason == f"action 2: pick up: {FRIDGE} is on the forks"


def test_whose_code_fails_is_told(folders, registered):
    @grounder("breaks")
    def breaks(task):
        """Break."""
        raise IndexError(task.text)

    with pytest.raises(CorpusError) as error:
        follow(folders, "breaks")
    assert "the grounder breaks fails: IndexError" in str(error.value)
    assert "test_other_grounders.py" in str(error.value)  # and the line in it
    assert "command forklift.automatic" in str(error.value)

    @parser("stumbles")
    def stumbles(text):
        """Break."""
        raise ValueError(text)

    with pytest.raises(CorpusError, match="the parser stumbles fails: ValueError"):
        run(*folders, configurations=("nearest",), parsers=["stumbles"])


def test_who_lacks_something_has_a_row_that_says_so(folders, registered):
    @grounder("heavy", missing=lambda: "needs a computer of its own")
    def heavy(task):
        """Never come to this."""
        raise AssertionError

    outcomes, result = follow(folders, "heavy")
    assert not outcomes
    found = rows(result.outcomes, result.facts, result.missing, draws=10, seed=0)
    (row,) = (r for r in found if (r["configuration"], r["subset"]) == ("heavy", "all"))
    assert (row["n"], row["note"]) == (0, "needs a computer of its own")


def test_a_parser_gives_the_model_its_clauses(folders, registered):
    said = []

    @parser("one-thing")
    def one_thing(text):
        """Whatever is said: take the refrigerator."""
        said.append(text)
        return parse_brackets("EVENT(r = Take, l = OBJ(f = the refrigerator))")

    result = run(*folders, configurations=("nearest",), parsers=["one-thing"])
    assert len(said) == 6
    themes = {o.text: o.theme for o in result.outcomes["one-thing"]}
    assert themes["Pick up the refrigerator."]
    assert themes["Put the washing machine on the trailer."] is False


def test_a_parser_is_compared_with_annotated_trees(folders, registered):
    @parser("as-annotated")
    def as_annotated(text):
        """Give what people gave, but nothing for one command."""
        (annotation,) = (a for a in few_annotated().annotations[:1])
        return annotation.sdcs if text == annotation.command.text else ()

    asked = ["--sdc", "--test", folders[0], "--parser", "as-annotated", "--json"]
    done = CliRunner().invoke(evaluate, asked)
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert found["parser"] == "as-annotated"
    assert (found["exact"], found["commands"]) == (0.5, 2)
    (wrong,) = found["errors"]
    assert wrong["predicted"] == ""


def test_names_are_given_once(registered):
    with pytest.raises(ValueError, match="the grounder 'keywords' is registered already"):
        grounder("keywords")(lambda task: [])
    with pytest.raises(ValueError, match="the judge 'automatic' is registered already"):
        plan_judge("automatic")(lambda plan: None)


def test_processes_hand_them_to_each_other_by_name():
    for one in (grounder_named("keywords"), judge_named("automatic")):
        assert pickle.loads(pickle.dumps(one)) is one
