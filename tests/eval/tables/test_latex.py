"""Tables in LaTeX."""

from pathlib import Path

from corpus_tools.corpus.estimate import Estimate, undefined
from eval.tables.formats import comments
from eval.tables.latex import RULE, estimate, tabular, text


def test_estimates():
    assert estimate(Estimate(0.5, 0.25, 0.75)) == r"0.50 {\scriptsize [0.25, 0.75]}"
    signed = estimate(Estimate(-0.5, -0.75, 0.1), "${:+.1f}$")
    assert signed == r"$-0.5$ {\scriptsize [$-0.8$, $+0.1$]}"
    assert estimate(Estimate(0.5)) == "0.50"
    assert estimate(Estimate(0.5, reason="all alike")) == r"0.50 {\scriptsize (all alike)}"
    assert estimate(undefined("separated")) == r"-- {\scriptsize (separated)}"
    assert estimate(Estimate(float("nan"))) == "--"


def test_a_table():
    made = tabular(("Name", "$n$"), [("a", "1"), RULE, ("b", "")], comments=["who", "why"])
    assert made.splitlines() == [
        r"% Needs \usepackage{booktabs}.",
        "% who",
        "% why",
        r"\begin{tabular}{lr}",
        r"\toprule",
        r"Name & $n$ \\",
        r"\midrule",
        r"a & 1 \\",
        r"\midrule",
        r"b & \\",
        r"\bottomrule",
        r"\end{tabular}",
    ]


def test_words_are_no_commands():
    assert text("gold-top30") == "gold-top30"
    assert text(r"5% of {a_b} & c#d ~ x^2 \ $") == (
        r"5\% of \{a\_b\} \& c\#d \textasciitilde{} x\textasciicircum{}2 \textbackslash{} \$"
    )


def test_comments_hold_no_folders():
    metadata = {
        "corpus": "/home/ann/aaai11",
        "train": "/home/ann/aaai11,warehouse,/srv/automatic",
        "sources": {"model": Path("/home/ann/g3.npz"), "seeds": [1, "/tmp/x"]},
        "share": "3/4",
    }
    assert comments(metadata) == [
        "corpus: aaai11",
        "train: aaai11,warehouse,automatic",
        'sources: {"model": "g3.npz", "seeds": [1, "x"]}',
        "share: 3/4",
    ]
