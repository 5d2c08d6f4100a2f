"""Commands won and lost by potentials."""

from benchmarks.potentials_off import attempts_of_corpus, effects
from corpus_tools.importers.authored.bundled import open_corpus
from eval.table_3 import end_to_end

NAMES = ["verb-put", "ordinal"]


def test_a_command_is_won_by_the_rule_that_it_needs(few):
    """One of the two commands puts a load down; neither has an ordinal."""
    corpus = open_corpus(few)
    rows = effects("few", attempts_of_corpus([corpus], few), NAMES)
    counts = {row["name"]: (row["n"], row["spoke"], row["won"], row["lost"]) for row in rows}
    assert counts == {"verb-put": (2, 1, 1, 0), "ordinal": (2, 0, 0, 0)}


def test_a_potential_that_says_nothing_changes_nothing(few):
    """Commands are not followed again without it."""
    with_all, without = (
        end_to_end.run(few, few, configurations=("gold",), ablate=ablated)
        for ablated in ((), ("ordinal",))
    )
    assert [o.evidence for o in with_all.outcomes["gold"]] == [
        o.evidence for o in without.outcomes["gold"]
    ]
