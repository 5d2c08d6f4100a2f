from __future__ import annotations

import pytest

from g3.examples import to_batch
from tests.g3.features.scenes import one, row, scene, table, thing

TIRES = thing("tires", "tire pallet", 5, 0)
BOXES = thing("boxes", "box pallet", 9, 0)
TRUCK = thing("truck", "trailer", 0, 9)
WORLD = scene(TIRES, BOXES, TRUCK)


def test_labels_are_those_that_all_of_the_figure_have() -> None:
    batch = to_batch(
        [
            row(WORLD, "OBJECT", TIRES),
            row(WORLD, "OBJECT", (TIRES, BOXES)),
            row(WORLD, "EVENT", TIRES),
        ]
    )
    values = table("labels", batch)
    assert list(values) == ["box", "forklift", "pallet", "tire", "trailer"]
    assert [values[label][0] for label in values] == [0, 0, 1, 1, 0]
    assert [values[label][1] for label in values] == [0, 0, 1, 0, 0]


def test_mixed_labels_are_those_that_some_of_a_plural_have() -> None:
    plural = one("mixed-labels", row(WORLD, "OBJECT", (TIRES, BOXES)))
    assert {name for name, value in plural.items() if value} == {"tire.some", "box.some"}
    single = one("mixed-labels", row(WORLD, "OBJECT", TIRES))
    assert not any(single.values())


@pytest.mark.parametrize(
    ("name", "type", "role"),
    [("landmark-labels", "PATH", "landmark"), ("theme-labels", "EVENT", "theme")],
)
def test_labels_of_other_arguments(name: str, type: str, role: str) -> None:
    values = one(name, row(WORLD, type, TRUCK, **{role: (TIRES, BOXES)}))  # type: ignore[arg-type]
    assert {label for label, value in values.items() if value} == {"box", "pallet", "tire"}


def test_word_label_similarity_of_the_figure_and_of_its_scene() -> None:
    # "lorry" is a synonym of the truck's label, which the figure hasn't got.
    values = one("word-label", row(WORLD, "OBJECT", TIRES, words="the tires lorry"))
    assert values["exact.own"] == values["lemma.own"] == values["domain.own"] == 1
    assert values["exact.other"] == 0
    assert values["domain.other"] == 1
    wrong = one("word-label", row(WORLD, "OBJECT", BOXES, words="the tires"))
    assert (wrong["lemma.own"], wrong["lemma.other"]) == (0, 1)
    assert wrong["spelling.own"] < wrong["spelling.other"] == 1


def test_labels_of_other_scenes_do_not_count() -> None:
    elsewhere = scene(TRUCK)
    example = row(elsewhere, "OBJECT", TRUCK, words="pallet")
    alone = one("word-label", example)
    batch = table("word-label", to_batch([row(WORLD, "OBJECT", TIRES), example]))
    assert alone["exact.other"] == 0
    assert {column: values[1] for column, values in batch.items()} == alone


def test_figures_without_words_are_like_no_label() -> None:
    batch = to_batch([row(WORLD, "OBJECT", TIRES), row(WORLD, "OBJECT", TIRES, words="pallet")])
    values = table("word-label", batch)
    assert {column_values[0] for column_values in values.values()} == {0}


def test_a_batch_without_any_figure_words() -> None:
    assert set(one("word-label", row(WORLD, "OBJECT", TIRES)).values()) == {0}
