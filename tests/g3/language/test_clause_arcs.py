"""SDC trees as arcs between words, and back."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from corpus_tools.corpus.annotated_trees import annotated_trees
from corpus_tools.importers.authored.bundled import open_corpus
from g3.language.parsing.clause_arcs import INSIDE, OUTSIDE, ROOT, Arcs, build_trees, read_arcs
from g3.language.parsing.words import cut
from g3.sdc.clauses import Span, breadth_first
from g3.sdc.sdc_notation import check_sdc, format_brackets, parse_brackets

GOLDEN = [
    (
        "Put the crate on it",
        "EVENT(r = Put, l = OBJ(f = the crate), l2 = PLACE(r = on, l = OBJ(f = it)))",
        [-1, 0, 1, 0, 3],
        ["root:EVENT", "l:OBJECT", "on", "l2:PLACE", "l:OBJECT"],
    ),
    (
        "Lift the crate on it",
        "EVENT(r = Lift, l = OBJ(f = OBJ(f = the crate), r = on, l = OBJ(f = it)))",
        [-1, 0, 1, 1, 3],
        ["root:EVENT", "l:OBJECT", "on", "mod:OBJECT=r", "l:OBJECT"],
    ),
    (
        "tires to it",
        "EVENT(l = OBJ(f = tires), l2 = PATH(r = to, l = OBJ(f = it)))",
        [-1, 0, 1],
        ["l:OBJECT/root:EVENT", "l2:PATH^1", "l:OBJECT"],
    ),
    (
        "Please lift it up",
        "EVENT(r = lift up, l = OBJ(f = it))",
        [-1, -1, 1, 1],
        ["out", "root:EVENT", "l:OBJECT", "on"],
    ),
]


@pytest.mark.parametrize(("text", "tree", "heads", "labels"), GOLDEN)
def test_golden_arcs(text, tree, heads, labels):
    spans = cut(text).spans
    sdcs = parse_brackets(tree, command=text)
    arcs = read_arcs(sdcs, spans)
    assert arcs == Arcs(tuple(heads), tuple(labels))
    assert build_trees(arcs, spans) == sdcs


def test_nearly_all_trees_of_the_bundled_corpus_are_their_arcs():
    items = annotated_trees(open_corpus("warehouse"))
    same = 0
    for item in items:
        spans = cut(item.command.text).spans
        again = build_trees(read_arcs(item.sdcs, spans), spans)
        same += format_brackets(again) == format_brackets(item.sdcs)
    assert same / len(items) > 0.9


LABELS = (
    *(OUTSIDE, INSIDE, "root:EVENT", "l:OBJECT", "f:OBJECT", "l2:PLACE", "l:PATH", "l2:EVENT"),
    *("mod:OBJECT=r", "m1:EVENT", "l:OBJECT/root:EVENT", "l2:PATH^1", "l:OBJECT/l:PATH^2"),
)


@st.composite
def arcs_of_words(draw):
    n = draw(st.integers(1, 40))
    order = draw(st.permutations(range(n)))
    heads, labels = [ROOT] * n, [OUTSIDE] * n
    for place, word in enumerate(order):
        heads[word] = draw(st.sampled_from([ROOT, *order[:place]]))
        labels[word] = draw(st.sampled_from(LABELS))
    return Arcs(tuple(heads), tuple(labels))


@given(arcs_of_words())
def test_any_arcs_make_trees_that_are_well_formed(arcs):
    spans = tuple(Span(2 * i, "x") for i in range(len(arcs.heads)))
    sdcs = build_trees(arcs, spans)
    words = [s for sdc in breadth_first(sdcs) for s in (*sdc.words, *sdc.relation)]
    assert len(words) == len(set(words))
    for sdc in sdcs:
        check_sdc(sdc)


@given(st.integers(30, 400))
def test_a_long_chain_is_cut_into_trees(n):
    heads = tuple(range(-1, n - 1))
    spans = tuple(Span(2 * i, "x") for i in range(n))
    labels = tuple("root:EVENT" if i == 0 else "l:PLACE" if i % 2 else "l:OBJECT" for i in range(n))
    sdcs = build_trees(Arcs(heads, labels), spans)
    for sdc in sdcs:
        check_sdc(sdc)
    assert sum(len(sdc.words) + len(sdc.relation) for sdc in breadth_first(sdcs)) == n
