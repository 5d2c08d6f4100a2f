"""Reading scenarios: what a file says, and at which line it is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from corpus_tools.world.scenarios.scenario import Robot, Thing
from corpus_tools.world.scenarios.scenario_reading import all_errors, read_layout, read_scenario
from corpus_tools.world.state.robot_script import ScriptStep
from g3.errors import FormatError
from tests.corpus_tools.world.scenarios.floor import LAYOUT, SCENARIO


def test_a_scenario_is_what_its_file_says(write):
    scenario = read_scenario(write())
    assert scenario.id == "x"
    assert scenario.title == "The forklift puts tires on the trailer."
    assert scenario.layout.name == "floor"
    assert scenario.objects["tires-1"] == Thing("tire-pallet", (7, 1.5))
    assert scenario.places["corner"].size == (2, 2)
    assert scenario.robot == Robot((0, 0))
    assert scenario.script == (
        ScriptStep("pick_up", "tires-1"),
        ScriptStep("put_down", "on-trailer-1"),
    )
    assert [*scenario.all_objects] == ["tires-1", "boxes-1", "boxes-2", "trailer-1", "shelf-a"]
    assert [*scenario.all_places] == ["on-trailer-1", "corner", "receiving"]


def change(text, old, new):
    assert old in text
    return text.replace(old, new, 1)


# Lines and columns counted by hand.
WRONG = [
    # the form
    ("at: [7, 1.5]", "at: [7, 1.5, 0]", "4:36: objects.tires-1.at: expected 2 numbers, got 3"),
    ("at: [7, 1.5]", "at: [7, left]", "4:40: objects.tires-1.at[1]: expected a number, got text"),
    ("at: [7, 1.5]", "at: here", "4:36: objects.tires-1.at: expected a list, got text"),
    ("at: [7, 1.5]", "on: [7, 1.5]", "4:36: objects.tires-1.on: there is no such field"),
    ("{kind: tire-pallet, at: [7, 1.5]}", "tires", "4:12: objects.tires-1: expected fields"),
    ("kind: tire-pallet, ", "", "4:3: objects.tires-1: the field 'kind' is missing"),
    ("at: [2.6, 9.55]", "at: [2.6, 9.55], size: [0, 1]",
     "9:59: places.on-trailer-1.size[0]: expected a number > 0"),
    ("robot: {at: [0, 0]}\n", "", "1:1: the field 'robot' is missing"),
    ("layout: floor", "site: floor", "1:1: the field 'layout' is missing"),
    ("layout: floor", "layout: roof", "2:9: layout: there is no layout 'roof'"),
    ("script:", "plan:", "1:1: the field 'script' is missing"),
    ("  - pick_up: tires-1", "  - [pick_up]", "13:5: script[0]: expected fields, got a list"),
    ("  - pick_up: tires-1", "  - {}", "13:5: script[0]: expected"),
    ("title: The forklift puts tires on the trailer.", "title: 3", "1:8: title: expected text"),
    # ids and kinds
    ("kind: tire-pallet", "kind: tyre", "4:19: objects.tires-1.kind: there is no kind 'tyre'"),
    ("kind: tire-pallet", "kind: forklift", "4:19: objects.tires-1.kind: there is no kind"),
    ("  boxes-2:", "  shelf-a:", "6:3: objects.shelf-a: the layout has a 'shelf-a' already"),
    ("  boxes-2:", "  Boxes 2:", "6:3: objects.Boxes 2: 'Boxes 2' can't be an id"),
    ("  boxes-2:", "  forklift:", "6:3: objects.forklift: the id 'forklift' is taken by the robot"),
    ("  corner:", "  boxes-2:", "10:3: places.boxes-2: an object has the id 'boxes-2'"),
    ("  corner:", "  receiving:", "10:3: places.receiving: the layout has a 'receiving' already"),
    # decks and loads
    ("deck: trailer-1, at: [1", "deck: trailer-2, at: [1",
     "5:37: objects.boxes-1.deck: there is no object 'trailer-2'"),
    ("deck: trailer-1, at: [1", "deck: tires-1, at: [1",
     "5:37: objects.boxes-1.deck: 'tires-1' has no deck"),
    ("{deck: trailer-1, at: [2.6", "{deck: truck-1, at: [2.6",
     "9:24: places.on-trailer-1.deck: there is no object 'truck-1'"),
    ("at: [1, 9.55], yaw", "at: [1, 9.2], yaw",
     "5:52: objects.boxes-1.at: boxes-1 is not wholly on the deck of trailer-1"),
    ("at: [1, 9.55], yaw", "at: [3.5, 9.5], yaw",
     "5:52: objects.boxes-1.at: boxes-1 is not wholly on the deck of trailer-1"),
    ("at: [2.6, 9.55]", "at: [4, 9.55]",
     "9:39: places.on-trailer-1.at: the middle of on-trailer-1 is not on the deck of trailer-1"),
    ("kind: tire-pallet, at: [7, 1.5]", "kind: tire-pallet",
     "4:3: objects.tires-1: it has no position"),
    ("{at: [0, 0]}", "{at: [0, 0], carries: tires-1}",
     "4:36: objects.tires-1.at: the robot carries it"),
    ("{at: [0, 0]}", "{at: [0, 0], carries: tires-3}",
     "11:30: robot.carries: there is no object 'tires-3'"),
    ("{at: [0, 0]}", "{at: [0, 0], carries: shelf-a}",
     "11:30: robot.carries: the forks can't lift 'shelf-a'"),
    ("kind: tire-pallet, at: [7, 1.5]", "kind: tire-pallet, at: [7, 1.5], liftable: false",
     "13:14: script[0].pick_up: the forks can't lift tires-1"),
    ("kind: tire-pallet, at: [7, 1.5]", "kind: barrel, at: [7, 1.5], liftable: true",
     "4:51: objects.tires-1.liftable: the forks can't lift a barrel"),
    ("kind: tire-pallet, at: [7, 1.5]", "kind: tire-pallet, at: [7, 1.5], colours: [red, mauve]",
     "4:61: objects.tires-1.colours[1]: 'mauve' is none of the choices"),
    # room
    ("at: [7, -3]", "at: [7.5, 2.5]",
     "6:35: objects.boxes-2.at: boxes-2 and tires-1 overlap"),
    ("at: [7, -3]", "at: [1, 12.85]", None),
    ("at: [7, -3]", "at: [1, 13.2]",
     "6:35: objects.boxes-2.at: boxes-2 and shelf-a overlap"),
    ("at: [7, -3]", "at: [19.6, -3]", "6:35: objects.boxes-2.at: boxes-2 is outside the layout"),
    ("at: [7, -3]", "at: [2.5, 10.4]",
     "7:34: objects.trailer-1.at: trailer-1 and boxes-2 overlap"),
    ("{at: [0, 0]}", "{at: [6, 1]}", "11:13: robot.at: forklift and tires-1 overlap"),
    ("{at: [0, 0]}", "{at: [5, 1]}", "11:13: robot.at: the forks and tires-1 overlap"),
    ("{at: [0, 0]}", "{at: [0, -15]}", "11:13: robot.at: forklift is outside the layout"),
    ("at: [-15, -10]", "at: [-19.5, -10]", "10:16: places.corner.at: corner is outside the layout"),
    # the script
    ("pick_up: tires-1", "lift: tires-1", "13:11: script[0].lift: there is no action 'lift'"),
    ("pick_up: tires-1", "pick_up: tires-2",
     "13:14: script[0].pick_up: there is no object 'tires-2'"),
    ("pick_up: tires-1", "pick_up: trailer-1",
     "13:14: script[0].pick_up: the forks can't lift trailer-1"),
    ("  - pick_up: tires-1\n", "", "13:15: script[0].put_down: nothing is on the forks"),
    ("put_down: on-trailer-1", "pick_up: boxes-2",
     "14:14: script[1].pick_up: tires-1 is on the forks already"),
    ("put_down: on-trailer-1", "put_down: trailer-1",
     "14:15: script[1].put_down: there is no place 'trailer-1'"),
    ("at: [2.6, 9.55]", "at: [1.6, 9.55]",
     "14:15: script[1].put_down: boxes-1 is in on-trailer-1, where tires-1 is to stand"),
    ("put_down: on-trailer-1", "drive_to: on-trailer-1",
     "14:15: script[1].drive_to: on-trailer-1 is on a deck, where the robot can't drive"),
    ("put_down: on-trailer-1", "approach: tires-1",
     "14:15: script[1].approach: tires-1 is on the forks"),
    ("put_down: on-trailer-1", "back_up_m: far", "14:16: script[1].back_up_m: 'far' is no number"),
    ("put_down: on-trailer-1", "forward_m: -1",
     "14:16: script[1].forward_m: -1 is not more than 0"),
    ("put_down: on-trailer-1", "drive_past: 3",
     "14:17: script[1].drive_past: there is no object 3"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "told"), WRONG)
def test_errors_name_the_line_the_column_and_the_field(write, old, new, told):
    file = write(change(SCENARIO, old, new))
    errors = [str(error).removeprefix(f"{file}:") for error in all_errors(file)]
    if told is None:
        assert errors == []
        return
    assert errors[0].startswith(told), errors
    with pytest.raises(FormatError) as caught:
        read_scenario(file)
    assert str(caught.value) == f"{file}:{errors[0]}"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("x: [-20, 20]", "x: [20, -20]", "4:13: bounds.x: 20 is not before -20"),
        ("bounds:", "limits:", "1:1: the field 'bounds' is missing"),
        ("at: [0, 14]", "at: [0, 15]", "6:30: objects.shelf-a.at: shelf-a is outside the layout"),
        ("at: [0, 14]", "", "6:3: objects.shelf-a: it has no position"),
        ("at: [15, 0]", "at: [18, 0]", "8:36: places.receiving.at: receiving is outside"),
        ("at: [10, 20]", "at: 10", "2:5: at: expected a list"),
    ],
)
def test_errors_of_layouts_name_their_file_too(write, old, new, told):
    file = write(layout=change(LAYOUT, old, new))
    layout = file.parent.parent / "layouts" / "floor.yaml"
    with pytest.raises(FormatError) as caught:
        read_layout(layout)
    assert str(caught.value).removeprefix(f"{layout}:").startswith(told)
    assert [str(error) for error in all_errors(file)] == [str(caught.value)]


def test_all_problems_are_listed(write):
    text = change(SCENARIO, "at: [7, 1.5]", "at: 7")
    text = change(text, "kind: trailer", "kind: 3")
    assert [error.where.rpartition(" ")[2] for error in all_errors(write(text))] == [
        "objects.tires-1.at",
        "objects.trailer-1.kind",
    ]


def test_the_form_of_commands_is_checked(write):
    commands = "commands:\n  - {text: Go, sdcs: EVENT_1(r = Go), groundings: {}}\n  - {text: Go}\n"
    file = write(SCENARIO + commands)
    assert [str(e).removeprefix(f"{file}:") for e in all_errors(file)] == [
        "17:5: commands[1]: the field 'sdcs' is missing (see docs/scenarios.md for the form)"
    ]


def test_touching_is_not_being_in_each_other(write):
    assert all_errors(write(change(SCENARIO, "at: [7, -3]", "at: [7, 0.3]"))) == []


def test_a_load_fits_between_two_others_to_be_put_down(write):
    text = change(SCENARIO, "at: [2.6, 9.55]", "at: [2.2, 9.55]")
    assert all_errors(write(text)) == []


def test_a_place_is_free_again_when_its_load_was_picked_up(write):
    text = change(SCENARIO, "corner: {at: [-15, -10]}", "corner: {at: [7, 1.5]}")
    text = change(text, "put_down: on-trailer-1", "put_down: corner")
    assert all_errors(write(text)) == []


def test_the_robot_cannot_stop_where_something_stands(write):
    text = change(SCENARIO, "corner: {at: [-15, -10]}", "corner: {at: [7, -3]}")
    text = change(text, "put_down: on-trailer-1", "drive_to: corner")
    assert "boxes-2 is in the middle of corner" in str(all_errors(write(text))[0])


def test_a_scenario_without_a_dataset_uses_the_bundled_layouts(tmp_path):
    file = tmp_path / "far" / "x.yaml"
    file.parent.mkdir()
    file.write_text("title: T\nlayout: dock\nrobot: {at: [0, 0]}\nscript: [drive_to: receiving]\n")
    assert read_scenario(file).layout.name == "dock"


def test_the_examples_in_the_documentation_are_right(tmp_path):
    documentation = Path(__file__).parents[4] / "docs" / "scenarios.md"
    scenario, coloured, layout = (
        part.partition("```")[0] for part in documentation.read_text().split("```yaml\n")[1:]
    )
    for name, text in (("layouts", layout), ("scenarios", scenario)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "dock.yaml").write_text(text)
    file = tmp_path / "scenarios" / "dock.yaml"
    assert read_scenario(file).layout.title == "A loading dock."
    rest = "robot: {at: [0, 0]}\nscript: [{pick_up: crate-1}]\n"
    file.write_text(f"title: Colours.\nlayout: dock\n{coloured}{rest}")
    assert read_scenario(file).objects["crate-2"].colours == ("white", "blue")
