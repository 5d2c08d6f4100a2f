from __future__ import annotations

import math
from pathlib import Path

import pytest

from g3.learning.examples import to_batch
from tests.g3.features.scenes import one, row, table
from tests.worlds import scene, thing

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


def test_likeness_in_form_of_the_figure_and_of_its_scene() -> None:
    values = one("word-form", row(WORLD, "OBJECT", TIRES, words="the tires"))
    assert values["lemma.own"] == 1
    assert values["exact.own"] == values["exact.other"] == 0
    wrong = one("word-form", row(WORLD, "OBJECT", BOXES, words="the tires"))
    assert (wrong["lemma.own"], wrong["lemma.other"]) == (0, 1)
    assert wrong["spelling.own"] < wrong["spelling.other"] == 1


def test_synonyms_of_the_figure_and_of_its_scene() -> None:
    # "lorry" is a synonym of the truck's label, which the figure hasn't got.
    values = one("word-domain", row(WORLD, "OBJECT", TIRES, words="the tires lorry"))
    assert values == {"domain.own": 1, "domain.other": 1}


def test_labels_of_other_scenes_do_not_count() -> None:
    elsewhere = scene(TRUCK)
    example = row(elsewhere, "OBJECT", TRUCK, words="pallet")
    alone = one("word-form", example)
    batch = table("word-form", to_batch([row(WORLD, "OBJECT", TIRES), example]))
    assert alone["exact.other"] == 0
    assert {column: values[1] for column, values in batch.items()} == alone


def test_figures_without_words_are_like_no_label() -> None:
    batch = to_batch([row(WORLD, "OBJECT", TIRES), row(WORLD, "OBJECT", TIRES, words="pallet")])
    values = table("word-form", batch)
    assert {column_values[0] for column_values in values.values()} == {0}


def test_a_batch_without_any_figure_words() -> None:
    assert set(one("word-form", row(WORLD, "OBJECT", TIRES)).values()) == {0}


@pytest.fixture
def tags(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tags by which a dolly is a truck's kin, and a skid is not."""
    file = tmp_path / "tags.txt"
    file.write_text("dolly trailer\ndolly trailer\ndolly pallet\nskid pallet\nrose tulip\n")
    monkeypatch.setenv("CT_TAGS", str(file))


@pytest.mark.usefixtures("tags")
def test_a_graded_measure_tells_which_thing_fits_best() -> None:
    # P(trailer | dolly) = 2 / 3, P(pallet | dolly) = 1 / 3.
    right = one("word-tags", row(WORLD, "OBJECT", TRUCK, words="the dolly"))
    wrong = one("word-tags", row(WORLD, "OBJECT", TIRES, words="the dolly"))
    assert right["tag-given.own"] == pytest.approx(2 / 3)
    assert right["tag-given.margin"] == pytest.approx(1 / 3)
    assert wrong["tag-given.margin"] == pytest.approx(-1 / 3)
    assert (right["tag-given.best"], wrong["tag-given.best"]) == (1, 0)


@pytest.mark.usefixtures("tags")
def test_things_with_the_same_labels_are_no_rivals() -> None:
    two = scene(TIRES, thing("more tires", "tire pallet", 7, 0))
    values = one("word-tags", row(two, "OBJECT", TIRES, words="skid"))
    assert (values["tag-given.margin"], values["tag-given.best"]) == (1, 1)


@pytest.mark.usefixtures("tags")
def test_a_graded_measure_says_nothing_of_unknown_words() -> None:
    assert all(map(math.isnan, one("word-tags", row(WORLD, "OBJECT", TIRES, words="ufo")).values()))
    assert all(map(math.isnan, one("word-tags", row(WORLD, "OBJECT", TIRES)).values()))
