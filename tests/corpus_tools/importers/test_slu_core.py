"""The importer on a small made-up corpus, whole and broken."""

from __future__ import annotations

import bz2
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from corpus_tools.cli.import_commands import import_
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.slu_core.slu_corpus import import_slu_core
from corpus_tools.importers.slu_core.slu_files import (
    EASY_NEGATIVES,
    NEGATIVES,
    POSITIVES,
    SCENARIOS,
)
from g3.errors import FormatError
from g3.groundings import Path as PathGrounding
from g3.groundings import PhysicalObject
from g3.sdc.clauses import SDC, Span, all_words, breadth_first

SMALL = Path(__file__).parents[2] / "data" / "slu_core_small"
BOXES = ("generator", "accessories", "pallet")


@pytest.fixture
def source(tmp_path):
    """A copy of the small corpus that a test may break."""
    shutil.copytree(SMALL, tmp_path / "source")
    return tmp_path / "source" / "data"


@pytest.fixture(scope="module")
def imported():
    return import_slu_core(SMALL, salt="salt")


@pytest.fixture(scope="module")
def by_id(imported):
    return {annotation.id: annotation for annotation in imported[0].annotations}


def replace(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def run(*args, **env):
    return CliRunner().invoke(import_, ["slu-core", *map(str, args)], env=env)


# What is read


def test_ids(imported, by_id):
    corpus, _ = imported
    assert list(corpus.contexts) == ["load_truck", "visit_dock"]
    assert list(corpus.commands) == [
        "load_truck-01", "load_truck-02", "load_truck-03", "visit_dock-01", "visit_dock-01_2"
    ]  # fmt: skip
    assert list(by_id) == [
        "load_truck-01/positive", "load_truck-02/positive", "visit_dock-01_2/positive",
        "load_truck-01/random", "load_truck-02/random",
        "visit_dock-01_2/easy", "visit_dock-01_2/easy-2",
    ]  # fmt: skip


def test_words_that_are_not_contiguous(by_id):
    assert by_id["load_truck-01/positive"].sdcs == (
        SDC(
            "EVENT",
            relation=(Span(0, "Put"), Span(20, "down")),
            figure=(SDC("OBJECT"),),
            landmark1=(SDC("OBJECT", words=(Span(4, "the"), Span(8, "tire"), Span(13, "pallet"))),),
            landmark2=(
                SDC(
                    "PLACE",
                    relation=(Span(25, "on"),),
                    landmark1=(SDC("OBJECT", words=(Span(28, "the"), Span(32, "truck"))),),
                ),
            ),
        ),
    )


def test_words_over_a_line_break(by_id):
    annotation = by_id["load_truck-02/positive"]
    assert annotation.command.text == "Take both pallets to\r\nthe dock and wait. "
    clauses = list(breadth_first(annotation.sdcs))
    assert [clause.type for clause in clauses] == [
        "EVENT", "OBJECT", "OBJECT", "PATH", "EVENT", "OBJECT", "OBJECT"
    ]  # fmt: skip
    assert clauses[3].relation == (Span(18, "to"), Span(22, "the"))
    assert clauses[6].is_implicit


def test_every_word_stands_in_its_command(imported):
    for annotation in imported[0].annotations:
        for sdc in annotation.sdcs:
            for span in all_words(sdc):
                assert annotation.command.text[span.start : span.end] == span.text


def test_a_plural_has_several_groundings(by_id):
    groundings = by_id["load_truck-02/positive"].groundings
    assert [g.labels for g in groundings[2]] == [("tire", "assembly", "pallet"), BOXES]
    assert isinstance(groundings[3][0], PathGrounding)
    assert groundings[3][0].trajectory.t == pytest.approx([1e-6, 2e-6])
    assert groundings[6] == ()


def test_missing_labels(by_id):
    assert by_id["load_truck-01/positive"].correct == (True, None, True, False, True)
    assert by_id["load_truck-01/random"].correct == (False, None, False, True, False)
    assert by_id["visit_dock-01_2/easy"].correct == (None, None, None, False, None, None)


def test_the_agent_is_in_every_context(imported):
    for context in imported[0].contexts.values():
        assert context.agent.labels == ("forklift",)
        assert len(context.agent.trajectory) == 3


def test_copies_of_objects_are_the_objects(imported, by_id):
    yard = {o.id: o for o in imported[0].contexts["load_truck"].objects}
    tires = by_id["load_truck-01/positive"].groundings[2][0]
    assert tires is yard["330574145942606080"]
    assert tires.trajectory.yaw == pytest.approx([0.785, 0.9])  # the copy has lost it
    boxes = by_id["load_truck-01/random"].groundings[2][0]
    assert boxes is yard["330574145942606081"]  # though its labels and times differ


def test_labels_are_unified(imported):
    labels = {
        grounding.labels
        for annotation in imported[0].annotations
        for groundings in annotation.groundings
        for grounding in groundings
        if isinstance(grounding, PhysicalObject)
    }
    assert BOXES in labels
    assert ("generator", "pallet") not in labels


def test_an_object_of_no_context_takes_the_heading_of_its_footprint(by_id):
    stray = by_id["load_truck-01/random"].groundings[4][0]
    assert stray.id == "999"
    assert stray.trajectory.yaw == pytest.approx([np.pi / 2])


def test_another_robot_is_not_this_context_s(imported, by_id):
    robot = by_id["load_truck-01/random"].groundings[0][0]
    assert robot.id == "-100"
    assert robot is not imported[0].contexts["load_truck"].agent
    assert robot.trajectory.yaw == pytest.approx([0.0])  # a robot's heading is never lost


def test_judgments(imported):
    first, second = imported[0].judgments
    assert (first.id, first.rating, first.study) == (
        "load_truck/evaluations-001", "SA", "evaluations"
    )  # fmt: skip
    assert first.command_video == first.shown_video == "video-a"
    assert (second.rating, second.shown_video) == ("N", "video-b")


def test_subjects_are_the_same_in_commands_and_judgments(imported):
    corpus, _ = imported
    first, second, third, *_ = corpus.commands.values()
    assert first.subject == third.subject != second.subject
    assert second.subject == corpus.judgments[0].subject
    other, _ = import_slu_core(SMALL, salt="pepper")
    assert other.commands["load_truck-01"].subject != first.subject
    assert other.hash == corpus.hash


def test_the_report(imported):
    _, report = imported
    assert report.skipped == ()
    assert {note.what: note.records for note in report.notes} == {
        "nothing was typed": ("load_truck-03",),
        "the annotated text differs from what was typed in white space only": ("load_truck-01",),
        "the annotated text differs from what was typed": ("load_truck-02",),
        "annotated in parts": ("visit_dock-01_2",),
        "headings of objects of the random negative, which are in no context and were not "
        "published, are taken from their footprints": ("load_truck-01",),
        "the SDC trees of the random negative differ from the positive's": ("load_truck-02",),
    }
    assert report.missing == (f"{SCENARIOS}/visit_dock/evaluations.run1.yaml",)
    assert report.not_imported == {"objects.xml": 0, "properties.yaml": 1}
    assert report.counts["annotations, easy"] == 2


def test_compressed_and_plain_files_give_the_same(source, imported):
    for name in (POSITIVES, NEGATIVES, EASY_NEGATIVES):
        path = source / name
        path.with_name(path.name + ".bz2").write_bytes(bz2.compress(path.read_bytes()))
        path.unlink()
    corpus, _ = import_slu_core(source, salt="salt")
    assert corpus == imported[0]


def test_negatives_may_be_missing(source):
    (source / NEGATIVES).unlink()
    (source / EASY_NEGATIVES).unlink()
    corpus, report = import_slu_core(source, salt="salt")
    assert {annotation.source for annotation in corpus.annotations} == {"positive"}
    assert {NEGATIVES, EASY_NEGATIVES} < set(report.missing)


def test_a_second_context_of_a_scenario_is_numbered(source):
    replace(source / POSITIVES, "context: *yard", "context: {objects: [], places: []}")
    corpus, _ = import_slu_core(source, salt="salt")
    assert list(corpus.contexts) == ["load_truck", "load_truck-2", "visit_dock"]
    assert corpus.annotations[1].context.id == "load_truck-2"


def test_another_wording_of_a_command_is_a_command_of_its_own(source):
    old, new = "You go past the crates near me", "Now go past the crates near me"
    path = source / EASY_NEGATIVES
    path.write_text(path.read_text().replace(old, new).replace("f: You", "f: Now"))
    corpus, _ = import_slu_core(source, salt="salt")
    assert corpus.commands["visit_dock-01_2/2"].text == new
    assert corpus.annotations[-1].id == "visit_dock-01_2/2/easy-2"


# What can't be read


BROKEN = [
    (POSITIVES, "r: Take", "r: Tke", "record 2 (ASSIGN2)", "command[1][0].EVENT.r"),
    (POSITIVES, "[down, [20, 24]]", "[down, [21, 25]]", "record 1 (ASSIGN1)", "EVENT.r[1]"),
    (POSITIVES, "[1.0, 0.5, 0.0, 0.1], [2.0, 0.5, 0.0, 0.2]], timestamps: ['1', '2']",
     "[.nan, 0.5, 0.0, 0.1], [2.0, 0.5, 0.0, 0.2]], timestamps: ['1', '2']",
     "record 2 (ASSIGN2)", "objectGroundings[3][0]: trajectory xyz holds a value that is not"),
    (POSITIVES, "timestamps: ['1', '2']", "timestamps: ['2', '1']", "record 2", "run backwards"),
    (POSITIVES, "timestamps: ['1', '2']", "timestamps: ['1']", "record 2", "shape"),
    (POSITIVES, "  - []\n  - []\n  - null", "  - []\n  - null", "record 2 (ASSIGN2)",
     "objectGroundings: 6 entries for 7 clauses"),
    (POSITIVES, "[null, null, true, false, null]", "[null]", "record 1", "groundingIsCorrect"),
    (POSITIVES, "[null, null, true, false, null]", "[1, null, true, false, null]", "record 1",
     "groundingIsCorrect[0]: 1 is not a label"),
    (POSITIVES, "ASSIGN1", "ASSIGN9", "record 1 (ASSIGN9)", "assignmentId"),
    (POSITIVES, "assignmentId: ASSIGN1\n  source", "source", "record 1", "no assignmentId"),
    (POSITIVES, "zEnd: 0.5", "zEnd: -3", "record 1", "context.objects[0].prism"),
    (POSITIVES, "tag: [tire, assembly, pallet]", "tag: [1]", "record 1", "objects[0].tag"),
    (POSITIVES, "agent: *robot", "agent: {lcmId: -100}", "record 2", "agent: this is not an obj"),
    (NEGATIVES, "[50, 50], [52, 50]", "[50, 50], [52]", "record 1", "[0][0].prism"),
    (NEGATIVES, "[Place, {", "[Spot, {", "record 1", "objectGroundings[3][0]: this is not a gro"),
    (EASY_NEGATIVES, "assignmentId: ASSIGN4_2", "assignmentId: ASSIGN4", "record 1 (ASSIGN4)",
     "no positive record"),
    (f"{SCENARIOS}/load_truck/evaluations.yaml", "similarityScore: SA", "similarityScore: OK",
     "record 1", "similarityScore: 'OK' is not a rating"),
    (f"{SCENARIOS}/load_truck/assignments.yaml", "ASSIGN3", "ASSIGN1", "record 3",
     "assignmentId: the assignment ASSIGN1 occurs twice"),
    (f"{SCENARIOS}/load_truck/assignments.yaml", "youtubeId", "youTubeId", "record 1", "youtubeId"),
]  # fmt: skip


@pytest.mark.parametrize(("file", "old", "new", "record", "what"), BROKEN)
def test_a_broken_record_is_an_error(source, tmp_path, file, old, new, record, what):
    replace(source / file, old, new)
    with pytest.raises(FormatError) as caught:
        import_slu_core(source, salt="salt")
    message = str(caught.value)
    assert message.startswith(file)
    assert record in message
    assert what in message
    assert caught.value.fix
    assert "--keep-going" in message


@pytest.mark.parametrize(("file", "old", "new", "record", "what"), BROKEN)
def test_a_broken_record_is_left_out_and_listed(source, tmp_path, file, old, new, record, what):
    replace(source / file, old, new)
    out = tmp_path / "out"
    result = run(source, "--out", out, "--keep-going")
    assert result.exit_code == 0, result.exception
    assert f"skipped: {file}: {record}" in result.output
    Corpus.load(out)
    report = (out / "import-report.json").read_text()
    assert f'"file": "{file}"' in report
    assert f'"record": "{record}' in report


def test_the_error_counts_the_others(source, tmp_path):
    replace(source / NEGATIVES, "r: Take", "r: Tke")
    replace(source / POSITIVES, "r: past", "r: fast")
    with pytest.raises(FormatError, match=r"record 3 .*3 more records can't be read"):
        import_slu_core(source, salt="salt")


def test_yaml_that_is_cut_off(source):
    path = source / POSITIVES
    text = path.read_text()
    path.write_text(text[: text.index("zStart: 0.5")])
    with pytest.raises(FormatError, match=r"withPaths.yaml: .*line \d+"):
        import_slu_core(source, salt="salt")


@pytest.mark.parametrize("name", [POSITIVES, EASY_NEGATIVES])
def test_a_compressed_file_that_is_cut_off(source, name):
    path = source / name
    compressed = bz2.compress(path.read_bytes())
    path.unlink()
    path.with_name(path.name + ".bz2").write_bytes(compressed[: len(compressed) // 2])
    with pytest.raises(FormatError, match=r"yaml.bz2: the compressed file is damaged or cut off"):
        import_slu_core(source, salt="salt")


def test_a_file_that_is_no_list(source):
    (source / NEGATIVES).write_text("a: 1")
    with pytest.raises(FormatError, match="holds a dict, not a list"):
        import_slu_core(source, salt="salt")


def test_a_file_that_is_no_text(source):
    (source / NEGATIVES).write_bytes(b"- \xff")
    with pytest.raises(FormatError, match="not UTF-8"):
        import_slu_core(source, salt="salt")


@pytest.mark.parametrize("content", ["", "[]", "# nothing"])
@pytest.mark.parametrize("keep_going", [True, False])
def test_an_empty_corpus(source, content, keep_going):
    for name in (POSITIVES, NEGATIVES, EASY_NEGATIVES):
        (source / name).write_text(content)
    with pytest.raises(FormatError, match="not a single annotation"):
        import_slu_core(source, salt="salt", keep_going=keep_going)


def test_the_wrong_folder_tells_what_was_looked_for(tmp_path):
    with pytest.raises(FormatError, match=rf"looked here and in data/ for {POSITIVES}"):
        import_slu_core(tmp_path, salt="salt")
    with pytest.raises(FormatError, match="no such folder"):
        import_slu_core(tmp_path / "nowhere", salt="salt")


# The command


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_with_a_salt_two_imports_give_the_same_bytes(tmp_path):
    told = json.loads(run(SMALL, "--out", tmp_path / "a", "--salt", "x", "--json").output)
    assert told["report"] == json.loads((tmp_path / "a/import-report.json").read_text())
    assert run(SMALL / "data", "--out", tmp_path / "b", CT_SALT="x").exit_code == 0
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


def test_without_a_salt_only_the_subjects_differ(tmp_path):
    for name in ("a", "b"):
        assert run(SMALL, "--out", tmp_path / name).exit_code == 0
    a, b = contents(tmp_path / "a"), contents(tmp_path / "b")
    different = {"commands.jsonl", "judgments.jsonl"}
    assert {name for name in a if a[name] != b[name]} == different | {"corpus.json"}
    one, other = (json.loads(files["corpus.json"]) for files in (a, b))
    digests, others = one.pop("digests"), other.pop("digests")
    assert one == other
    assert {name for name in digests if digests[name] != others[name]} == different
    assert Corpus.load(tmp_path / "a").hash == Corpus.load(tmp_path / "b").hash


def test_no_worker_id_is_stored(tmp_path):
    run(SMALL, "--out", tmp_path / "a")
    assert b"WORKER" not in b"".join(contents(tmp_path / "a").values())


def test_a_failed_import_leaves_nothing(source, tmp_path):
    replace(source / POSITIVES, "r: Take", "r: Tke")
    result = run(source, "--out", tmp_path / "out")
    assert isinstance(result.exception, FormatError)
    assert [path.name for path in tmp_path.iterdir()] == ["source"]


def test_an_existing_corpus_is_kept_without_force(tmp_path):
    out = tmp_path / "out"
    assert run(SMALL, "--out", out).exit_code == 0
    before = contents(out)
    assert isinstance(run(SMALL, "--out", out).exception, FormatError)
    assert contents(out) == before
    assert run(SMALL, "--out", out, "--force").exit_code == 0
