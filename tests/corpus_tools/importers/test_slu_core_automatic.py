"""Random tasks: worlds, commands, what was done, and files that are not as they should be."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

from corpus_tools.cli.corpus_commands import corpus as corpus_command
from corpus_tools.cli.import_commands import import_
from corpus_tools.corpus.corpus_reading import load_corpus
from corpus_tools.corpus.corpus_validation import validate
from corpus_tools.corpus.start_headings import parse_heading, with_headings
from corpus_tools.corpus.task_outcomes import contexts_of_commands, is_drive, outcomes_of
from corpus_tools.importers.slu_core.slu_parts import import_parts
from g3.errors import FormatError
from tests.corpus_tools.importers import random_tasks as made

GROUP = "forklift.automatic.v1"
WORLD = f"{GROUP}/2011_1_manip"


@pytest.fixture
def group(tmp_path):
    return tmp_path / "source" / "data" / "corpusCommandsForVideoSmallFilesOnly" / GROUP


def read(group, **options):
    return import_parts(group, salt="salt", part="automatic", **options)


def noted(report):
    return {note.what: note.records for note in report.notes}


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
    assert load_corpus(tmp_path / "a").contexts[WORLD].assumed == corpus.contexts[WORLD].assumed


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


# What is not as it should be: told of, marked, and never dropped


def test_a_picked_pallet_that_is_not_there(group):
    made.put_world(group, status=made.log(made.TO_CHECKPOINT.format("99", "3")))
    corpus, report = read(group)
    (outcome,) = corpus.outcomes
    assert (outcome.picked, outcome.put, outcome.unknown) == ((), "ground", ("picked", "place"))
    assert not is_drive(outcome)
    assert noted(report) == {"what was picked up is not in objects.xml": (f"{WORLD}: 99",)}


def test_a_trailer_that_is_not_there(group):
    xml = made.objects(made.pallet("11", "1", "0 0 0"))
    made.put_world(group, xml=xml, status=made.log(made.TO_TRAILER.format("11")))
    corpus, report = read(group)
    assert corpus.outcomes[0].unknown == ("on",)
    assert "a load is put on a trailer, and there is none in objects.xml" in noted(report)


@pytest.mark.parametrize(
    ("line", "picked", "checkpoint", "unknown"),
    [
        ("Generating PMC Task: Pickup pallet_id = 12 and drop-off on the moon",
         ("12",), None, ("put", "place")),
        ("Generating Dance: checkpoint_id = 7", (), 7, ("picked", "put", "place")),
    ],
)  # fmt: skip
def test_a_task_of_another_form(group, line, picked, checkpoint, unknown):
    made.put_world(group, status=made.log(line))
    corpus, report = read(group)
    (outcome,) = corpus.outcomes
    assert (outcome.picked, outcome.checkpoint, outcome.unknown) == (picked, checkpoint, unknown)
    assert outcome.log == line
    assert noted(report) == {"a task of the log isn't understood": (f"{WORLD}: {line}",)}


def test_a_line_of_another_form(group):
    made.put_world(group, status=made.log(made.PICK_UP.format("11"), "Pallet fell off"))
    corpus, report = read(group)
    assert corpus.outcomes[0].unknown == ("rest",)
    assert noted(report) == {"a line of the log isn't understood": (f"{WORLD}: Pallet fell off",)}


def test_a_log_that_is_cut_off(group):
    status = made.log(made.PICK_UP.format("11")).replace("Looks like we're done", "")
    made.put_world(group, status=status)
    corpus, report = read(group)
    assert corpus.outcomes[0].unknown == ("rest",)
    assert "the log doesn't end as logs do, so more may have been done" in noted(report)


@pytest.mark.parametrize("status", [None, "", b"\x00\xff\xfe\x81 nothing"])
def test_no_log(group, status):
    made.put_world(group, status=status)
    made.put_world(group, "2011_2_manip")
    corpus, report = read(group)
    outcome = corpus.outcomes[0]
    assert {"picked", "put", "place"} <= set(outcome.unknown)
    assert ("-100", "position") in corpus.contexts[WORLD].assumed
    assert len(corpus.commands) == 4
    assert "the log tells of no task, so what was done is unknown" in noted(report)


def test_unknown_numbers(group):
    xml = made.objects(
        made.pallet("11", "99", "0 0 0"),
        made.thing("12", "2", "0 9 0"),
        made.pallet("13", "", "5 5 0"),
    )
    made.put_world(group, xml=xml)
    corpus, report = read(group)
    context = corpus.contexts[WORLD]
    assert [o.labels for o in context.objects] == [
        ("pallet",),
        ("object",),
        ("pallet",),
        ("forklift",),
    ]
    assert {("11", "labels"), ("12", "labels"), ("13", "labels")} < set(context.assumed)
    assert noted(report) == {
        "unknown label of a pallet: 99": (f"{WORLD}: 11",),
        "unknown type of an object: 2": (f"{WORLD}: 12",),
        "unknown label of a pallet: none": (f"{WORLD}: 13",),
    }


def test_items_that_are_odd(group):
    xml = made.objects(
        made.pallet("11", "1", "0 0 0"),
        made.pallet("11", "1", "4 0 0"),
        made.pallet("", "1", "8 0 0"),
        made.pallet("12", "1", "somewhere"),
        made.pallet("13", "1", "9 9 0", "0 0 0 0"),
        '<item type="flag"><id>14</id><position id="local-frame">1 1 0</position></item>',
    )
    made.put_world(group, xml=xml)
    corpus, report = read(group)
    context = corpus.contexts[WORLD]
    assert [o.id for o in context.objects] == ["11", "11-2", "item-3", "13", "14", "-100"]
    assert ("13", "heading") in context.assumed
    assert len(report.notes) == 6


def test_files_that_are_missing(group):
    made.put_world(group, xml=None, commands=None, properties=None)
    made.put_world(group, "2011_2_manip")
    corpus, report = read(group)
    assert [o.id for o in corpus.contexts[WORLD].objects] == ["-100"]
    assert len(corpus.commands) == 2
    assert len(report.missing) == 3
    assert {"nobody has typed a command", "what was picked up is not in objects.xml"} < set(
        noted(report)
    )


def test_an_empty_folder_is_a_world_of_which_nothing_is_known(group):
    made.put_world(group)
    (group / "2011_2_manip").mkdir()
    corpus, report = read(group)
    assert len(corpus.contexts) == len(corpus.outcomes) == 2
    assert len(report.missing) == 4


def test_commands_that_are_odd(group):
    made.put_world(
        group,
        commands="""\
- {assignmentId: A1, command: null, workerId: W1, youtubeId: vid}
- {assignmentId: A1, command: Lift it., workerId: W1}
- {command: 12, youtubeId: other}
""",
    )
    corpus, report = read(group)
    texts = [(c.text, c.video, bool(c.subject)) for c in corpus.commands.values()]
    assert texts == [("", "vid", True), ("Lift it.", "vid", True), ("12", "other", False)]
    assert noted(report) == {
        "nothing was typed": (f"{WORLD}-01",),
        "an assignment occurs twice": (f"{WORLD}-02",),
        "commands are of several videos; the outcome is that of one": (f"{WORLD}: vid",),
    }
    told = [len(outcomes_of(corpus, command)) for command in corpus.commands.values()]
    assert told == [1, 1, 0]  # of the other video nobody knows


@pytest.mark.parametrize("encoding", ["cp1252", "utf-8-sig", "utf-16"])
def test_other_encodings(group, encoding):
    text = made.COMMANDS.replace("fridge", "café")
    made.put_world(
        group,
        commands=text.encode(encoding),
        xml=made.YARD.encode(encoding),
        status=made.log(made.PICK_UP.format("11")).encode(encoding),
    )
    corpus, report = read(group)
    assert corpus.commands[f"{WORLD}-01"].text == "Pick up the café."
    assert corpus.outcomes[0].picked == ("11",)
    what = "the file is not UTF-8 text; it was read as Windows-1252"
    assert (what in noted(report)) == (encoding == "cp1252")


@pytest.mark.parametrize(
    ("broken", "file"),
    [
        ({"xml": "<objects><item>"}, "objects.xml"),
        ({"xml": '<!DOCTYPE a [<!ENTITY b "c">]><objects>&b;</objects>'}, "objects.xml"),
        ({"commands": "- {assignmentId: A1, comm"}, "assignments.yaml"),
        ({"commands": "just words"}, "assignments.yaml"),
        ({"commands": "- just words"}, "assignments.yaml"),
    ],
)
def test_what_cannot_be_read_is_an_error_or_left_out(group, tmp_path, broken, file):
    made.put_world(group, **broken)
    made.put_world(group, "2011_2_manip")
    with pytest.raises(FormatError, match=rf"2011_1_manip/{file}.*--keep-going"):
        read(group)
    result = run(group, "--part", "automatic", "--out", tmp_path / "a", "--keep-going")
    assert result.exit_code == 0, result.exception
    assert "skipped: " in result.output
    assert len(load_corpus(tmp_path / "a").contexts) == 2


def test_other_files_are_counted(group):
    (made.put_world(group) / "video.mp4").write_bytes(b"")
    assert read(group)[1].not_imported == {"video.mp4": 1}


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
    corpus = load_corpus(out)
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
