"""Random tasks: worlds, commands, what was done, and files that are not as they should be."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

from corpus_tools.cli.corpus_commands import corpus as corpus_command
from corpus_tools.cli.import_commands import import_
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_validation import validate
from corpus_tools.corpus.start_headings import parse_heading, with_headings
from corpus_tools.corpus.task_outcomes import contexts_of_commands, outcomes_of
from corpus_tools.importers.slu_core.slu_corpus import import_parts
from g3.errors import FormatError
from tests.corpus_tools.importers import random_tasks as made

GROUP = "forklift.automatic.v1"
WORLD = f"{GROUP}/2011_1_manip"


@pytest.fixture
def group(tmp_path):
    return tmp_path / "source" / "data" / "corpusCommandsForVideoSmallFilesOnly" / GROUP


def read(group, **options):
    return import_parts(group, salt="salt", part="automatic", **options)


def run(*args):
    return CliRunner().invoke(import_, ["slu-core", *map(str, args)])


# Worlds


def test_positions_of_pallets_and_trailers_are_corners(group):
    made.put_world(group)
    corpus, report = read(group)
    things = {item.id: item for item in corpus.contexts[WORLD].objects}
    # 1.2 m along the heading and 1.0 m across it, from (1, 2): the middle is half of that away.
    assert things["11"].labels == ("refrigerator", "pallet")
    assert things["11"].trajectory.xyz[0, :2] == pytest.approx([1.6, 2.5])
    assert things["11"].prism.xy.min(axis=0) == pytest.approx([1.0, 2.0])
    assert things["11"].prism.xy.max(axis=0) == pytest.approx([2.2, 3.0])
    # Turned by 90°: ahead is +y and left is -x.
    assert things["12"].labels == ("washing", "machine", "pallet")
    assert things["12"].trajectory.xyz[0, :2] == pytest.approx([0.5, -3.4])
    assert things["12"].trajectory.yaw == pytest.approx([np.pi / 2])
    # The deck of a trailer, 5.36 m by 1.91 m.
    assert things["13"].labels == ("flatbed", "trailer")
    assert things["13"].trajectory.xyz[0, :2] == pytest.approx([2.68, 10.955])
    assert (things["13"].prism.z_min, things["13"].prism.z_max) == (0.44, 0.85)
    # Of anything else it is the middle, and it stands on the ground.
    assert things["14"].labels == ("operator",)
    assert things["14"].trajectory.xyz[0, :2] == pytest.approx([5, 5])
    assert things["14"].prism.z_min == 0
    assert report.notes == ()


def test_the_second_edge_of_a_footprint_points_ahead(group):
    # As in the contexts of the paper's corpus.
    made.put_world(group)
    corpus, _ = read(group)
    for item in corpus.contexts[WORLD].objects[:-1]:
        edge = item.prism.xy[2] - item.prism.xy[1]
        assert np.arctan2(edge[1], edge[0]) == pytest.approx(item.trajectory.yaw[0])


def test_a_pallet_on_a_trailer_stands_on_its_deck(group):
    made.put_world(group, xml=made.objects(made.pallet("11", "22", "1 11 0.85")))
    (tires, _) = read(group)[0].contexts[WORLD].objects
    assert tires.labels == ("tire", "pallet")
    assert (tires.prism.z_min, tires.prism.z_max) == pytest.approx((0.85, 1.55))


def test_what_is_assumed_is_told(group, tmp_path):
    made.put_world(group)
    corpus, _ = read(group)
    assert corpus.contexts[WORLD].assumed == (
        ("11", "size"), ("12", "size"), ("14", "size"), ("-100", "heading")
    )  # fmt: skip
    assert run(group, "--part", "automatic", "--out", tmp_path / "a").exit_code == 0
    assert Corpus.load(tmp_path / "a").contexts[WORLD].assumed == corpus.contexts[WORLD].assumed


def test_the_robot_starts_where_the_log_says_and_faces_the_loads(group):
    made.put_world(group)
    robot = read(group)[0].contexts[WORLD].agent
    assert robot.trajectory.xyz[0] == pytest.approx([-10, 2, 0])
    # The middles of the loads are (1.6, 2.5) and (0.5, -3.4): that of both is (1.05, -0.45).
    toward = np.arctan2(-2.45, 11.05)
    assert robot.trajectory.yaw == pytest.approx([toward])
    edge = robot.prism.xy[1] - robot.prism.xy[0]
    assert np.arctan2(edge[1], edge[0]) == pytest.approx(toward)


@pytest.mark.parametrize(
    ("rule", "degrees"),
    [
        ("90", 90),
        ("-45.5", -45.5),
        ("east", 0),
        ("east+10", 10),
        ("loads", np.degrees(np.arctan2(-2.45, 11.05))),
        ("loads+30", np.degrees(np.arctan2(-2.45, 11.05)) + 30),
        # The middles of the trailer, (2.68, 10.955), and of the operator, (5, 5), come in.
        ("things", np.degrees(np.arctan2(15.055 / 4 - 2, 9.78 / 4 + 10))),
    ],
)
def test_headings_can_be_chosen_and_changed(group, rule, degrees):
    made.put_world(group)
    at_import, _ = read(group, heading=rule)
    robot = at_import.contexts[WORLD].agent
    assert np.degrees(robot.trajectory.yaw[0]) == pytest.approx(degrees)
    later = with_headings(read(group)[0], parse_heading(rule))
    assert later.contexts[WORLD].agent.prism.xy == pytest.approx(robot.prism.xy)
    assert later.contexts[WORLD].agent.trajectory.yaw == pytest.approx(robot.trajectory.yaw)
    assert later.outcomes == at_import.outcomes
    assert later.commands == at_import.commands


def test_with_its_own_heading_a_corpus_stays_what_it_is(group):
    made.put_world(group)
    corpus, _ = read(group, heading="90")
    assert with_headings(corpus, parse_heading("90")).hash == corpus.hash
    assert with_headings(corpus, parse_heading("91")).hash != corpus.hash


@pytest.mark.parametrize("rule", ["", "north", "loads30", "30+loads", "nan", "+", "loads+"])
def test_what_is_no_heading_is_refused(group, rule):
    made.put_world(group)
    with pytest.raises(FormatError, match="is not a heading"):
        read(group, heading=rule)


# What was done


@pytest.mark.parametrize(
    ("tasks", "expected"),
    [
        ([made.PICK_UP.format("11")], [(("11",), "held", (), None, ())]),
        ([made.TO_TRAILER.format("12")], [(("12",), "on", ("13",), None, ())]),
        ([made.TO_CHECKPOINT.format("11", "33")], [(("11",), "ground", (), 33, ("place",))]),
        ([made.DRIVE.format("24")], [((), "", (), 24, ("place",))]),
        (
            [made.DRIVE.format("26"), made.PICK_UP.format("11")],
            [((), "", (), 26, ("place",)), (("11",), "held", (), None, ())],
        ),
    ],
)
def test_what_was_done(group, tasks, expected):
    made.put_world(group, status=made.log(*tasks))
    corpus, report = read(group)
    found = [(o.picked, o.put, o.on, o.checkpoint, o.unknown) for o in corpus.outcomes]
    assert found == expected
    assert [o.log for o in corpus.outcomes] == tasks
    assert [o.id for o in corpus.outcomes] == [f"{WORLD}/{n + 1}" for n in range(len(tasks))]
    assert report.notes == ()
    for command in corpus.commands.values():
        assert outcomes_of(corpus, command) == corpus.outcomes
        assert contexts_of_commands(corpus)[command.id] == WORLD


def test_on_which_of_two_trailers_is_unknown(group):
    xml = made.objects(
        made.pallet("11", "1", "0 0 0"),
        made.thing("13", "5", "0 9 0"),
        made.thing("15", "5", "9 9 0"),
    )
    made.put_world(group, xml=xml, status=made.log(made.TO_TRAILER.format("11")))
    (outcome,) = read(group)[0].outcomes
    assert (outcome.put, outcome.on, outcome.unknown) == ("on", ("13", "15"), ("on",))


# Where it may lie


@pytest.mark.parametrize("up", [0, 1, 2, 3])
def test_any_folder_from_the_clone_down_to_the_group_is_the_same(group, up):
    made.put_world(group)
    path = [group, *group.parents][up]
    corpus, report = import_parts(path, salt="salt", part="automatic")
    assert corpus == read(group)[0]
    assert report.parts_there == report.parts_taken == ("automatic",)
    assert import_parts(path, salt="salt", part="all")[0] == corpus


def test_the_default_part_that_is_not_there(group, tmp_path):
    made.put_world(group)
    with pytest.raises(FormatError, match="the part aaai11 is not there; automatic is") as caught:
        import_parts(group.parents[2], salt="salt")
    assert "--part automatic" in caught.value.fix
    with pytest.raises(FormatError, match="this is not slu_core"):
        import_parts(tmp_path, salt="salt", part="automatic")


# The command, and what shows corpora


def test_the_corpus_is_written_sound_and_shown(group, tmp_path):
    made.put_world(group, status=made.log(made.TO_TRAILER.format("11")))
    out = tmp_path / "a"
    told = json.loads(run(group, "--part", "automatic", "--out", out, "--json").output)
    assert told["report"]["parts_taken"] == ["automatic"]
    assert validate(out) == []
    assert b"WORKER" not in b"".join(path.read_bytes() for path in out.iterdir())
    corpus = Corpus.load(out)
    assert corpus.outcomes[0].on == ("13",)

    def show(*args):
        result = CliRunner().invoke(corpus_command, list(map(str, args)))
        assert result.exit_code == 0, result.exception
        return result.output

    done = "picked up refrigerator pallet 11, put it on flatbed trailer 13"
    assert f"done: {done}" in show("show", out, f"{WORLD}-01")
    assert f"done: {done}" in show("show", out, WORLD)
    assert done in show("show", out, f"{WORLD}/1")
    assert "assumed heading: -100" in show("show", out, WORLD)
    record = json.loads(show("show", out, f"{WORLD}-01", "--json"))
    assert record["outcomes"][0]["on"] == ["13"]
    assert "outcomes, put on something" in show("stats", out)
    assert json.loads(show("stats", out, "--json"))["outcomes"]["tasks"] == 1
    assert json.loads(show("show", out, "--json"))["outcomes"] == 1
