"""The same commands as other people type them, beside those as typed."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("spacy")

from corpus_tools.corpus.annotated_trees import with_perturbed_commands
from corpus_tools.importers.authored.bundled import open_corpus
from eval.cli.eval_commands import evaluate
from eval.parsing.sdc_scores import SDCChoices, render, run
from g3.language.parsing.perturbation import PERTURBATIONS
from g3.sdc.clauses import breadth_first


@pytest.mark.parametrize("mode", ["sdc", "table3"])
def test_the_command_line_knows_all_kinds(mode):
    (option,) = [p for p in evaluate.commands[mode].params if p.name == "perturb"]
    assert set(option.type.choices) == set(PERTURBATIONS)


@pytest.mark.parametrize("kind", PERTURBATIONS)
def test_a_corpus_keeps_its_groundings(kind):
    corpus = open_corpus("warehouse")
    other = with_perturbed_commands(corpus, kind)
    assert other.hash != corpus.hash
    assert [c.text for c in other.commands.values()] != [c.text for c in corpus.commands.values()]
    for before, after in zip(corpus.annotations, other.annotations, strict=True):
        assert after.command is other.commands[before.command.id]
        assert (before.groundings, before.correct) == (after.groundings, after.correct)
        for clause in breadth_first(after.sdcs):
            spans = (*clause.words, *clause.relation)
            assert all(after.command.text[s.start : s.end] == s.text for s in spans)


def test_each_perturbation_has_its_figures():
    trials, metadata = run(SDCChoices(test="warehouse", perturb=("articles", "capitals")))
    assert list(trials) == ["", "articles", "capitals"]
    assert len({len(own) for own in trials.values()}) == 1
    told = json.loads(render(trials, "json", metadata, top=3, terminal=False))
    assert list(told["perturbed"]) == ["articles", "capitals"]
    assert told["perturbed"]["capitals"]["typed_f"] == pytest.approx(told["typed_f"], abs=0.01)
    shown = render(trials, "text", metadata, top=3, terminal=False)
    assert "The same commands perturbed" in shown
    assert "as typed" in shown
