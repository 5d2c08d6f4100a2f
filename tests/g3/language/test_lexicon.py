import ast
from itertools import combinations
from pathlib import Path

import pytest

import g3
from g3.language.lexicon import word_sets as lexicon
from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.word_sets import ORDINALS, stems, words

SETS = {name: own for name, own in vars(lexicon).items() if isinstance(own, frozenset)}
READERS = sorted(
    path
    for folder in ("inference", "language", "features")
    for path in (Path(g3.__file__).parent / folder).rglob("*.py")
    if path.name != "word_sets.py"
)


def test_a_concept_has_one_home():
    assert len(SETS) > 40
    equal = [pair for pair in combinations(sorted(SETS), 2) if SETS[pair[0]] == SETS[pair[1]]]
    assert equal == []


def test_words_are_as_they_are_looked_up():
    assert words("left right") == {"left", "right"}
    assert stems("lonely isolated") == {normalise("lonely"), normalise("isolated")}
    spelled = [own for own in SETS.values() if own != lexicon.SENTENCE_ENDS]
    assert all(word == word.lower().strip(".,") for own in spelled for word in own)
    assert (ORDINALS["third"], ORDINALS["10th"]) == (3, 10)


@pytest.mark.parametrize("path", READERS, ids=lambda path: path.stem)
def test_other_modules_have_no_word_sets_of_their_own(path):
    """Sets of strings that modules define are of other things: kinds of actions, labels of arcs."""
    found = [
        node.lineno
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, (ast.Assign, ast.AnnAssign))
        and isinstance(node.value, ast.Call)
        and getattr(node.value.func, "id", "") == "frozenset"
    ]
    allowed = {"negation.py": 1, "word_roles.py": 2, "directions.py": 1}
    allowed["universal_dependencies.py"] = 4
    assert len(found) <= allowed.get(path.name, 0), found
