"""The importer of authored corpora, with a corpus of two scenarios."""

from __future__ import annotations

from dataclasses import replace

import pytest

from corpus_tools.importers.authored.authored_corpus import import_authored
from corpus_tools.logs.log_writing import write_log
from corpus_tools.world.scenarios.scenario_logs import FINGERPRINT, fingerprint
from corpus_tools.world.scenarios.scenario_reading import read_scenario
from g3.annotation import Annotation
from g3.errors import FormatError
from g3.groundings import Path
from g3.sdc.clauses import breadth_first
from tests.corpus_tools.importers.authored_logs import sliding, write_logs
from tests.processes import python

DATASET = """
name: tiny
source: Written for a test.
licence: CC0-1.0
seed: 7
words:
  the: []
  tires: [tire]
  boxes: [box]
  trailer: [trailer]
"""
LAYOUT = """
title: A floor.
at: [10, 20]
yaw_deg: 90
bounds: {x: [-20, 20], y: [-15, 15]}
"""
PUT = """
title: Tires are put on a trailer.
layout: a
robot: {at: [0, 0]}
script:
  - pick_up: tires-1
  - put_down: on-trailer
objects:
  tires-1: {kind: tire-pallet, at: [6, 0]}
  boxes-1: {kind: box-pallet, at: [6, 5]}
  trailer-1: {kind: trailer, at: [2, -8]}
places:
  on-trailer: {deck: trailer-1, at: [2, -8]}
  elsewhere: {at: [12, 5]}
commands:
  - text: Put the tires on the trailer.
    sdcs: |
      EVENT_1(r = Put, l = OBJ_2(f = the tires),
              l2 = PLACE_3(r = on, l = OBJ_4(f = the trailer)))
    groundings: {OBJ_2: tires-1, PLACE_3: on-trailer, OBJ_4: trailer-1}
"""
GO = """
title: The forklift drives on with what it carries.
layout: a
robot: {at: [0, 0], yaw_deg: 45, carries: tires-1}
script:
  - drive_to: corner
objects:
  tires-1: {kind: tire-pallet}
places:
  corner: {at: [8, 8], name: the corner}
commands:
  - text: Go on to the corner there
    sdcs: EVENT_1(r = Go on, l = PATH_2(r = to, l = OBJ_3(f = OBJ_4(f = the corner), r = there)))
    groundings: {OBJ_4: corner}
  - text: I want that
    sdcs: "EVENT_1(f = OBJ_2(f = I), r = want, l = OBJ_3(f = that))"
    groundings: {EVENT_1: [], OBJ_2: [], OBJ_3: tires-1}
"""


def write(folder, dataset=DATASET, put=PUT, go=GO):
    for name, texts in (("layouts", {"a": LAYOUT}), ("scenarios", {"put": PUT, "go": GO})):
        (folder / name).mkdir()
        for stem, text in texts.items():
            (folder / name / f"{stem}.yaml").write_text(text)
    write_logs(folder)
    (folder / "dataset.yaml").write_text(dataset)
    (folder / "scenarios" / "put.yaml").write_text(put)
    (folder / "scenarios" / "go.yaml").write_text(go)
    return folder


@pytest.fixture
def tiny(tmp_path):
    return import_authored(write(tmp_path))


def find(corpus, name) -> Annotation:
    return next(a for a in corpus.annotations if a.id == name)


def test_a_command_gets_a_positive_and_a_random_annotation(tiny):
    corpus, report = tiny
    assert corpus.name == "tiny"
    assert corpus.licence == "CC0-1.0"
    assert [a.id for a in corpus.annotations] == [
        f"{command}/{source}"
        for command in ("go-01", "go-02", "put-01")
        for source in ("positive", "random")
    ]
    assert {c.subject for c in corpus.commands.values()} == {"authored"}
    assert report.counts["commands"] == 3
    assert [file.file for file in report.files] == [
        "dataset.yaml",
        "scenarios/go.yaml",
        "logs/go.mcap",
        "scenarios/put.yaml",
        "logs/put.mcap",
    ]


def test_clauses_are_grounded_breadth_first(tiny):
    annotation = find(tiny[0], "put-01/positive")
    context = annotation.context
    agent = context.agent
    objects = {o.id: o for o in context.objects}
    assert annotation.groundings == (
        (agent,),
        (),  # the unnamed robot
        (objects["tires-1"],),
        (context.places[0],),
        (objects["trailer-1"],),
    )
    assert annotation.correct == (True, None, True, True, True)


def test_paths_and_relations_are_grounded_by_themselves(tiny):
    annotation = find(tiny[0], "go-01/positive")
    by_type = {
        sdc.type: g
        for sdc, g in zip(breadth_first(annotation.sdcs), annotation.groundings, strict=True)
    }
    assert by_type["PATH"] == (Path(annotation.context.agent.trajectory),)
    assert annotation.groundings[3] == annotation.groundings[4] == annotation.context.places


def test_events_can_be_left_ungrounded(tiny):
    annotation = find(tiny[0], "go-02/positive")
    assert annotation.groundings[:2] == ((), ())
    assert annotation.correct == (None, None, True)


def test_the_layout_moves_and_turns_everything(tiny):
    context = tiny[0].contexts["put"]
    boxes = next(o for o in context.objects if o.id == "boxes-1")
    assert boxes.trajectory.xyz[0] == pytest.approx([10 - 5, 20 + 6, 0.525])
    assert context.places[0].prism.xy.mean(axis=0) == pytest.approx([10 + 8, 20 + 2])
    assert context.places[0].prism.z_min == 0.85


def test_the_log_moves_what_the_script_names(tiny):
    moved = {
        name: {o.id for o in context.objects if len(o.trajectory) > 1}
        for name, context in tiny[0].contexts.items()
    }
    assert moved == {"put": {"tires-1", "forklift"}, "go": {"tires-1", "forklift"}}


def test_one_more_command_changes_no_other_draws(tmp_path, tiny):
    (tmp_path / "more").mkdir()
    more = PUT + "  - {text: Hm, sdcs: EVENT_1(r = Hm), groundings: {}}\n"
    corpus, _ = import_authored(write(tmp_path / "more", put=more))
    before, after = find(tiny[0], "put-01/random"), find(corpus, "put-01/random")
    assert before.groundings == after.groundings
    assert before.correct == after.correct


@pytest.mark.parametrize(
    ("old", "new", "where", "what"),
    [
        ("PLACE_3: on-trailer", "PLACE_3: in-air", "groundings.PLACE_3", "'in-air'"),
        ("OBJ_2: tires-1", "OBJ_2: boxes-1", "groundings.OBJ_2", "can't be boxes-1"),
        (", OBJ_4: trailer-1", "", "groundings.OBJ_4", "no grounding"),
        ("OBJ_4: trailer-1", "OBJ_5: trailer-1", "groundings.OBJ_5", "no clause"),
        ("{OBJ_2", "{EVENT_1: forklift, OBJ_2", "groundings.EVENT_1", "in the log"),
        ("PLACE_3: on-trailer", "PLACE_3: trailer-1", "groundings.PLACE_3", "in an object"),
        ("PLACE_3: on-trailer", "PLACE_3: elsewhere", "groundings.PLACE_3", "ends in the place"),
        ("OBJ_4(f", "OBJ_9(f", "sdcs", "not numbered"),
        ("EVENT_1(", "EVENT(", "sdcs", "not numbered"),
        ("f = the tires", "f = the tyres", "sdcs", "'tyres' is not in the command"),
        ("r = Put,", "r = Put", "sdcs", "expected"),
        ("groundings:", "grounding:", "grounding", "no such field"),
        ("text: Put the tires on the trailer.", "text: 3", "text", "expected text"),
    ],
)
def test_errors_name_the_file_the_command_and_the_field(tmp_path, old, new, where, what):
    assert old in PUT
    write(tmp_path, put=PUT.replace(old, new))
    with pytest.raises(FormatError) as caught:
        import_authored(tmp_path)
    assert caught.value.where.startswith("scenarios/put.yaml:16: command 1 (")
    assert where in caught.value.where or where in caught.value.what
    assert what in caught.value.what


@pytest.mark.parametrize(
    ("old", "new", "where", "what"),
    [
        ("layout: a", "layout: b", "3:9: layout", "no layout 'b'"),
        ("kind: box-pallet", "kind: box", "10:19: objects.boxes-1.kind", "no kind 'box'"),
        ("script:", "action:", "2:1", "'script' is missing"),
        ("layout: a", "layout: [", "5:1", "not YAML"),
        ("commands:", "commands: 3\nx:", "15:11: commands", "expected a list"),
    ],
)
def test_errors_name_the_line_and_the_field(tmp_path, old, new, where, what):
    assert old in PUT
    write(tmp_path, put=PUT.replace(old, new, 1))
    with pytest.raises(FormatError) as caught:
        import_authored(tmp_path)
    assert caught.value.where == f"scenarios/put.yaml:{where}"
    assert what in caught.value.what


def test_errors_of_the_dataset_name_it(tmp_path):
    write(tmp_path, dataset=DATASET.replace("tires: [tire]", "tires: tire"))
    with pytest.raises(FormatError, match=r"dataset\.yaml:8:10: words\.tires: expected a list"):
        import_authored(tmp_path)


def test_a_log_that_is_missing_is_told_with_the_command_that_makes_it(tmp_path):
    (write(tmp_path) / "logs" / "go.mcap").unlink()
    with pytest.raises(FormatError, match="there is no log") as caught:
        import_authored(tmp_path)
    assert caught.value.where == str(tmp_path / "logs" / "go.mcap")
    assert f"ct scenarios log go --dataset {tmp_path}" in caught.value.fix


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("at: [6, 5]", "at: [6, 5.1]"),
        ("elsewhere: {at: [12, 5]}", "elsewhere: {at: [12, 5], name: there}"),
        ("put_down: on-trailer", "put_down: elsewhere"),
        ("kind: box-pallet", "kind: crate"),
    ],
)
def test_a_log_of_another_world_is_refused(tmp_path, old, new):
    assert old in PUT
    write(tmp_path, put=PUT.replace(old, new, 1))
    with pytest.raises(FormatError, match="changed after its log"):
        import_authored(tmp_path)


def test_a_layout_that_was_moved_makes_logs_stale(tmp_path):
    write(tmp_path)
    (tmp_path / "layouts" / "a.yaml").write_text(LAYOUT.replace("yaw_deg: 90", "yaw_deg: 80"))
    with pytest.raises(FormatError, match="changed after its log"):
        import_authored(tmp_path)


def test_titles_and_commands_are_no_part_of_the_log(tmp_path):
    write(
        tmp_path, put=PUT.replace("title: Tires", "title: The tires").replace("Put the", "Put the ")
    )
    corpus, _ = import_authored(tmp_path)
    assert "put-01" in corpus.commands


def test_a_log_that_does_not_show_the_script_is_refused(tmp_path):
    write(tmp_path)
    path = tmp_path / "scenarios" / "put.yaml"
    scenario = read_scenario(path)
    recording = sliding(replace(scenario, script=scenario.script[:1]))
    metadata = {FINGERPRINT: fingerprint(scenario)}
    write_log(recording, tmp_path / "logs" / "put.mcap", name="put", metadata=metadata)
    with pytest.raises(FormatError, match="tires-1 doesn't move in the log"):
        import_authored(tmp_path)


def test_importing_needs_no_simulator(tmp_path):
    write(tmp_path)
    program = (
        "import sys; from pathlib import Path; sys.modules['mujoco'] = None;"
        "from corpus_tools.importers.authored.authored_corpus import import_authored;"
        "print(len(import_authored(Path(sys.argv[1]))[0].commands))"
    )
    assert python("-c", program, tmp_path).stdout == "3\n"


def test_another_folder_is_no_authored_corpus(tmp_path):
    with pytest.raises(FormatError, match="not an authored corpus"):
        import_authored(tmp_path)


def test_keep_going_leaves_out_what_cannot_be_read(tmp_path):
    write(tmp_path, put=PUT.replace("PLACE_3: on-trailer", "PLACE_3: in-air"))
    corpus, report = import_authored(tmp_path, keep_going=True)
    assert [*corpus.commands] == ["go-01", "go-02"]
    assert [(s.file, s.field) for s in report.skipped] == [
        ("scenarios/put.yaml:16", "groundings.PLACE_3")
    ]
