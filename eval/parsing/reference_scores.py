"""Accuracy of OBJECTs' references by words alone, against annotated trees and groundings.

Antecedents of pronouns (:mod:`g3.language.discourse.anaphora`) are compared with the groundings:
one is right if it has the pronoun's groundings. The number of an OBJECT
(:mod:`g3.language.discourse.groups`) is compared with its number of groundings.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from corpus_tools.corpus.annotated_trees import annotated_commands
from g3.annotation import Annotation
from g3.groundings import Grounding, PhysicalObject
from g3.language.discourse.anaphora import anaphors
from g3.language.discourse.groups import group
from g3.sdc.clauses import all_words, breadth_first


@dataclass(frozen=True, slots=True)
class ReferenceScores:
    """Counts over the grounded commands of a corpus.

    Parameters
    ----------
    pronouns
        Grounded anaphors of the kind `same`.
    any_antecedent
        Those that have a right antecedent among the candidates.
    first_antecedent
        Those whose most probable antecedent is right.
    singular
        Grounded OBJECTs that are singular by their words.
    singular_of_one
        Those that are grounded in one thing.
    plural
        Grounded OBJECTs that are plural by their words.
    plural_of_one
        Those that are grounded in one thing all the same.
    """

    pronouns: int = 0
    any_antecedent: int = 0
    first_antecedent: int = 0
    singular: int = 0
    singular_of_one: int = 0
    plural: int = 0
    plural_of_one: int = 0


def reference_scores(annotations: Iterable[Annotation]) -> ReferenceScores:
    """Count over the first positive annotation of each command."""
    chosen = annotated_commands(annotations)
    right = [found for annotation in chosen.values() for found in _antecedents(annotation)]
    sizes = [found for annotation in chosen.values() for found in _sizes(annotation)]
    singular = [size for number, size in sizes if number == "singular"]
    plural = [size for number, size in sizes if number == "plural"]
    return ReferenceScores(
        pronouns=len(right),
        any_antecedent=sum(any(found) for found in right),
        first_antecedent=sum(bool(found) and found[0] for found in right),
        singular=len(singular),
        singular_of_one=singular.count(1),
        plural=len(plural),
        plural_of_one=plural.count(1),
    )


def _antecedents(annotation: Annotation) -> Iterator[list[bool]]:
    """Yield for each grounded pronoun which of its antecedents are right."""
    for anaphor in anaphors(annotation.sdcs):
        meant = _things(annotation.groundings[anaphor.index])
        if anaphor.kind == "same" and meant:
            yield [
                _things(annotation.groundings[antecedent.index]) == meant
                for antecedent in anaphor.antecedents
            ]


def _things(groundings: Iterable[Grounding]) -> frozenset[Grounding | str]:
    return frozenset(g.id if isinstance(g, PhysicalObject) else g for g in groundings)


def _sizes(annotation: Annotation) -> Iterator[tuple[str, int]]:
    """Yield grammatical number and count of groundings of each OBJECT grounded in things."""
    inside: set[int] = set()
    for sdc, groundings in zip(breadth_first(annotation.sdcs), annotation.groundings, strict=True):
        if sdc.type != "OBJECT":
            continue
        inside.update(id(figure) for figure in sdc.figure)
        things = bool(groundings) and all(isinstance(g, PhysicalObject) for g in groundings)
        if things and id(sdc) not in inside and all_words(sdc):
            yield group(sdc).number, len(groundings)
