"""Annotated trees to roles, and roles to trees."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.language.parsing.spacy_pipeline import analyse
from g3.language.parsing.training.attachment_training import annotated_choice
from g3.language.parsing.tree_assembly import assemble
from g3.language.parsing.word_roles import ROLES, read_roles
from g3.sdc.clauses import Span
from g3.sdc.sdc_notation import check_sdc, format_brackets, parse_brackets

TREES = {
    "phrasal verb": (
        "Put the tire pallet down.",
        "EVENT(r = Put down, l = OBJ(f = the tire pallet))",
    ),
    "verb with two arguments": (
        "Put the pallet on the truck.",
        "EVENT(r = Put, l = OBJ(f = the pallet), l2 = PLACE(r = on, l = OBJ(f = the truck)))",
    ),
    "modified noun": (
        "Go to the pallet on the truck.",
        "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = OBJ(f = the pallet), r = on, "
        "l = OBJ(f = the truck))))",
    ),
    "two modifiers of one noun": (
        "Lift the pallet of tires on the left.",
        "EVENT(r = Lift, l = OBJ(f = OBJ(f = OBJ(f = the pallet), r = of, l = OBJ(f = tires)), "
        "r = on the left))",
    ),
    "modifier of a landmark": (
        "Lift the crate on the forks of your truck.",
        "EVENT(r = Lift, l = OBJ(f = OBJ(f = the crate), r = on, l = OBJ(f = OBJ(f = the forks), "
        "r = of, l = OBJ(f = your truck))))",
    ),
    "pair of landmarks": (
        "Park between the barrel on the right and the wall.",
        "EVENT(r = Park, l = PLACE(r = between, l = OBJ(f = OBJ(f = the barrel), "
        "r = on the right), l2 = OBJ(f = the wall)))",
    ),
    "several places": (
        "Leave it on the ground, behind you.",
        "EVENT(r = Leave, l = OBJ(f = it), l2 = [PLACE(r = on, l = OBJ(f = the ground)), "
        "PLACE(r = behind, l = OBJ(f = you))])",
    ),
    "several events": (
        "Turn left, then lift the crate. Wait.",
        "EVENT(r = Turn left)\nEVENT(r = lift, l = OBJ(f = the crate))\nEVENT(r = Wait)",
    ),
    "event in an event": (
        "Drive until you reach the wall.",
        "EVENT(r = Drive, l = EVENT(r = until, l = EVENT(f = OBJ(f = you), r = reach, "
        "l = OBJ(f = the wall))))",
    ),
    "clause of a noun": (
        "Go to the first crate you see.",
        "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = OBJ(f = the first crate), "
        "l = EVENT(f = OBJ(f = you), r = see))))",
    ),
    "landmark before its relation": (
        "Drop the crate you are holding.",
        "EVENT(r = Drop, l = OBJ(f = OBJ(f = the crate), r = are holding, l = OBJ(f = you)))",
    ),
    "place before the verb": (
        "From the truck, take the crate.",
        "EVENT(r = take, l = OBJ(f = the crate), l2 = PATH(r = From, l = OBJ(f = the truck)))",
    ),
    "apposition": (
        "Lift the crate on the left, the last one.",
        "EVENT(r = Lift, l = [OBJ(f = OBJ(f = the crate), r = on the left), "
        "OBJ(f = the last one)])",
    ),
    "statement": (
        "The crate goes on the truck.",
        "EVENT(f = OBJ(f = The crate), r = goes, l = PLACE(r = on, l = OBJ(f = the truck)))",
    ),
    "fragment": (
        "the crate on the left",
        "OBJ(f = OBJ(f = the crate), r = on the left)",
    ),
}


@pytest.mark.parametrize("name", TREES)
def test_trees_are_told_by_roles(name):
    text, notation = TREES[name]
    sdcs = parse_brackets(notation, command=text)
    (command,) = analyse([text])
    starts = [span.start for span in command.spans]
    reading = read_roles(sdcs, starts, [span.end for span in command.spans])
    choose = annotated_choice(reading)
    assembled = assemble(reading.roles, command.spans, command.lower, choose)
    assert format_brackets(assembled, positions=True) == format_brackets(sdcs, positions=True)


def test_roles_of_a_command_worked_by_hand():
    text = "Lift the pallet of tires on the left"
    sdcs = parse_brackets(TREES["two modifiers of one noun"][1], command=text)
    starts = [text.index(word) for word in text.split()]
    starts[6] = text.rindex("the")
    ends = [start + len(word) for start, word in zip(starts, text.split(), strict=True)]
    reading = read_roles(sdcs, starts, ends)
    assert reading.roles == (
        "event",
        "noun",
        "noun-on",
        "modifier",
        "noun",
        "modifier",
        "relation-on",
        "relation-on",
    )
    assert reading.modified == {3: 1, 5: 1}


words = st.sampled_from([*"abc", "the", "is", "of", "between", "and", "until", ",", ".", "you"])


@given(st.lists(st.tuples(words, st.sampled_from(ROLES)), max_size=120), st.randoms())
def test_any_roles_give_well_formed_trees_of_their_words(pairs, random):
    starts = [5 * i for i in range(len(pairs))]
    spans = [Span(start, word) for start, (word, _) in zip(starts, pairs, strict=True)]

    def choose(_modifier, nouns):
        return random.randrange(len(nouns))

    lower = [word for word, _ in pairs]
    roles = [role for _, role in pairs]
    sdcs = assemble(roles, spans, lower, choose)
    found = []
    pending = list(sdcs)
    for sdc in pending:
        check_sdc(sdc)
        found += [*sdc.words, *sdc.relation]
        pending += sdc.children()
    inside = [span for span, role in zip(spans, roles, strict=True) if role != "outside"]
    assert sorted(found) == inside
