"""``ct eval --table 3`` on made-up random tasks, of which only the outcomes are known."""

import csv
import io
import json

import pytest
from click.testing import CliRunner

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import open_corpus
from eval.cli.eval_commands import evaluate
from eval.table_3.end_to_end import run
from eval.table_3.judged_commands import facts, in_headings, judged_commands
from g3.errors import CorpusError
from g3.language.similarity import static_embeddings
from tests.eval.yard import yards

KEYS = (
    *("configuration", "subset", "n", "precision", "low", "high"),
    *("theme", "theme_low", "theme_high", "chance", "refusals"),
)
BASELINES = ("random", "nearest", "keywords", "embeddings")


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    return yards(tmp_path_factory.mktemp("yards"))


def test_what_is_known_of_the_commands(corpus):
    known = {c.command.text: facts(c) for c in judged_commands(corpus)}
    assert len(known) == 6
    held = known["Pick up the refrigerator."]
    assert (held.chance, held.is_determined, held.has_choice) == (0.5, True, True)
    assert known["Put the washing machine on the trailer."].is_determined
    # Where on the ground isn't recorded, nor where a robot went that only drove.
    assert not known["Pick up the washer and put it down."].is_determined
    drive = known["Turn around and go."]
    assert (drive.chance, drive.is_determined) == (0.0, False)
    assert not known["Pick up the pallet."].has_choice
    assert len({f.person for f in known.values()}) == 2
    assert len(judged_commands(corpus, most=1)) == 5


def test_baselines_worked_by_hand(folders):
    result = run(*folders, configurations=("nearest", "keywords"), most=0)
    told = {
        name: {o.text: (o.correct, o.theme) for o in own} for name, own in result.outcomes.items()
    }
    assert told["keywords"] == {
        "Pick up the refrigerator.": (True, True),
        "Lift the thing on the left.": (True, True),
        "Put the washing machine on the trailer.": (True, True),
        # "Washer" is no label, and the refrigerator is nearer.
        "Pick up the washer and put it down.": (False, False),
        "Turn around and go.": (True, True),
        "Pick up the pallet.": (True, True),
    }
    # The right place, but the load that is nearest to the robot.
    assert told["nearest"]["Put the washing machine on the trailer."] == (False, False)


@pytest.mark.slow
def test_there_are_rows_without_a_log_for_all_parts(folders, tmp_path):
    out = tmp_path / "table-3.json"
    asked = ["--table", "3", "--judge", "automatic", "--train", folders[0], "--test", folders[1]]
    asked += ["--draws", "50"]
    done = CliRunner().invoke(evaluate, [*asked, "--json", "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert list(tmp_path.iterdir()) == [out]
    found = json.loads(out.read_text())
    rows = {(row["configuration"], row["subset"]): row for row in found["rows"]}
    subsets = ("all", "determined", "two-or-more")
    names = (*BASELINES, "paper", "auto-top30", "auto-all")
    assert set(rows) == {(name, subset) for name in names for subset in subsets}
    for row in rows.values():
        assert set(KEYS) <= set(row)
    assert [rows["auto-all", subset]["n"] for subset in subsets] == [6, 4, 5]
    assert rows["keywords", "all"]["precision"] == pytest.approx(5 / 6)
    assert rows["keywords", "two-or-more"]["theme"] == pytest.approx(4 / 5)
    assert rows["auto-all", "two-or-more"]["chance"] == pytest.approx(2 / 5)
    assert found["object_grounding_top1"] is None
    # Nobody has compared verdicts by outcomes with people's.
    assert (found["compared_with"], found["judge_validity"]) == ("outcomes", None)
    assert ("keywords", "auto") in {(c["one"], c["other"]) for c in found["comparisons"]}


@pytest.mark.slow
def test_several_headings_and_what_spreadsheets_get(folders, monkeypatch):
    monkeypatch.setattr(static_embeddings, "find_spec", lambda _: None)
    asked = ["--table", "3", "--judge", "automatic", "--train", folders[0], "--test", folders[1]]
    asked += ["--most", "1", "--heading", "loads", "--heading", "loads+180", "--draws", "20"]
    done = CliRunner().invoke(evaluate, [*asked, "--format", "csv"])
    assert done.exit_code == 0, done.output
    rows = {
        (row["configuration"], row["subset"]): row
        for row in csv.DictReader(io.StringIO(done.output))
    }
    assert rows["auto-all", "all"]["n"] == "5"
    gone = rows["embeddings", "all"]
    assert (gone["n"], gone["precision"]) == ("0", "")
    assert "corpus-tools-g3[embeddings]" in gone["note"]
    assert json.loads(rows["nearest", "all"]["headings"]) == ["loads", "loads+180"]


def test_left_and_right_follow_the_heading(corpus):
    turned = in_headings(corpus, ["loads", "loads+180"])
    assert list(turned) == ["loads", "loads+180"]
    assert in_headings(corpus, []) == {"": corpus}
    yaw = [next(iter(c.contexts.values())).agent.trajectory.yaw[0] for c in turned.values()]
    assert yaw[1] - yaw[0] == pytest.approx(3.14159, abs=1e-4)


def test_recorded_headings_are_not_turned():
    with pytest.raises(CorpusError, match="headings are recorded"):
        in_headings(open_corpus("warehouse"), ["loads"])


def test_a_corpus_that_tells_nothing_is_refused(corpus):
    silent = Corpus.build(
        "silent",
        contexts=corpus.contexts.values(),
        commands=corpus.commands.values(),
        annotations=(),
    )
    with pytest.raises(CorpusError, match="no command has an annotation or an outcome"):
        judged_commands(silent)
    with pytest.raises(CorpusError, match="in a world with things"):
        judged_commands(open_corpus("treebank"))
