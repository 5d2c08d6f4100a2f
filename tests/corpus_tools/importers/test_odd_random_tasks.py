"""Random tasks whose files are not as they should be: told of, marked, and never dropped."""

from __future__ import annotations

from xml.sax.saxutils import escape

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from corpus_tools.cli.import_commands import import_
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_tables import encode
from corpus_tools.corpus.decoding import World
from corpus_tools.corpus.decoding import outcome as decode_outcome
from corpus_tools.corpus.task_outcomes import is_drive, outcomes_of
from corpus_tools.importers.slu_core.automatic_corpus import (
    outcomes_of_log,
    place_robot,
    read_log,
    read_things,
)
from corpus_tools.importers.slu_core.slu_corpus import import_parts
from g3.errors import FormatError
from tests.corpus_tools.importers import random_tasks as made

GROUP = "forklift.automatic.v1"
WORLD = f"{GROUP}/2011_1_manip"


@pytest.fixture
def group(tmp_path):
    return tmp_path / GROUP


def read(group):
    return import_parts(group, salt="salt", part="automatic")


def noted(report):
    return {note.what: note.records for note in report.notes}


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
    assert "a load is put on a trailer, and objects.xml has none for it" in noted(report)


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
    command = ["slu-core", str(group), "--part", "automatic", "--out", str(tmp_path / "a")]
    result = CliRunner().invoke(import_, [*command, "--keep-going"])
    assert result.exit_code == 0, result.exception
    assert "skipped: " in result.output
    assert len(Corpus.load(tmp_path / "a").contexts) == 2


def test_other_files_are_counted(group):
    (made.put_world(group) / "video.mp4").write_bytes(b"")
    assert read(group)[1].not_imported == {"video.mp4": 1}


# Any file


TAGS = st.sampled_from(["item", "id", "type", "label", "position", "orientation", "flag"])
VALUES = st.sampled_from(
    ["1 2 3", "1 0 0 0", "nan 0 0", "1e999 0 0", "..1 2 3", "19", "5", "", "x"]
) | st.text(max_size=5)


def elements(children):
    return st.builds(
        lambda tag, kind, frame, inner: (
            f'<{tag} type="{kind}" id="{frame}">{"".join(inner)}</{tag}>'
        ),
        TAGS,
        st.sampled_from(["pallet", "object", "flag"]),
        st.sampled_from(["local-frame", "lat_lon_theta"]),
        st.lists(children, max_size=6),
    )


XML = st.recursive(VALUES.map(escape), elements, max_leaves=30).map("<objects>{}</objects>".format)


@given(xml=XML | st.text(max_size=50), status=st.text(max_size=80))
def test_whatever_the_files_hold_it_is_read_or_refused_properly(xml, status):
    told = []
    try:
        things = read_things(xml, lambda *what: told.append(what))
    except FormatError:
        return
    log = read_log(status)
    context = place_robot("world", things, log.start, lambda *what: told.append(what))
    outcomes = outcomes_of_log(log, context, "", lambda *what: told.append(what))
    assert len({item.id for item in context.objects}) == len(context.objects)
    assert {name for name, _ in context.assumed} <= {item.id for item in context.objects}
    assert outcomes


LINES = st.sampled_from(
    [made.PICK_UP, made.TO_TRAILER, made.TO_CHECKPOINT, made.DRIVE, "Generating {} {}", "ok"]
)


@given(st.lists(st.tuples(LINES, st.sampled_from(["11", "13", "99", "-100", ""])), max_size=4))
def test_whatever_was_done_the_record_fits_together(lines):
    log = read_log(made.log(*(line.format(name, 7) for line, name in lines)))
    context = place_robot("world", read_things(made.YARD, print), log.start, print)
    outcomes = outcomes_of_log(log, context, "", lambda *_: None)
    corpus = Corpus.build("c", contexts=[context], commands=[], annotations=[], outcomes=outcomes)
    world = World({}, corpus.contexts, {("world", o.id): o for o in context.objects})
    records = encode(corpus.content).outcomes
    assert tuple(decode_outcome(record, world) for record in records) == outcomes
