"""``ct eval --report`` on a tiny corpus with ratings, plans and a video."""

import csv
import io
import json
import re
import shutil
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.video.encode import encode
from eval.cli.eval_commands import evaluate
from eval.judging.judge_report import with_validity
from eval.report.charts import Line, differences, intervals
from eval.report.plan_results import bins, calibration_error, read_all_plans, read_plans
from eval.report.report_contents import examples, failures
from eval.report.report_page import beside
from eval.statistics.estimates import Estimate
from eval.table_1.correspondence import Predictions
from eval.table_3.end_to_end import EndToEnd
from eval.table_3.judged_commands import Facts
from eval.table_3.outcomes import Outcome
from eval.table_3.plan_report import render
from eval.table_3.plan_rows import ALONE
from eval.tables.plot_style import NARROW, WIDE
from g3.annotation import Judgment
from g3.errors import FormatError
from tests.chromium import CHROMIUM
from tests.tiny_corpus import tiny_corpus

ODD = "Go <script>alert(1)</script> & there"


@pytest.fixture(scope="module")
def corpus():
    tiny = tiny_corpus()
    command = next(iter(tiny.commands.values()))
    judgments = [
        Judgment(f"{shown}-{rater}", ODD, command.video, shown, rating, f"r{rater}", "s")
        for shown in (command.video, "another")
        for rater, rating in enumerate(
            ("A", "SA", "D") * 2 if shown == command.video else ["D"] * 4
        )
    ]
    made = Corpus.build(
        "tiny <b>",
        contexts=list(tiny.contexts.values()),
        commands=list(tiny.commands.values()),
        annotations=tiny.annotations,
        judgments=judgments,
        source=tiny.source,
    )
    return replace(made, judgments=tuple(judgments))


@pytest.fixture(scope="module")
def plans(tmp_path_factory):
    outcomes = [
        Outcome(f"c{i}", f"s{i % 3}", "Go.", i / 9, i > 4, "" if i > 4 else "it stands still")
        for i in range(10)
    ]
    about = {"table": 3, "judge": "automatic"}
    facts = {o.command: Facts(f"p{i % 2}", 0.5, has_choice=i > 3) for i, o in enumerate(outcomes)}
    which = ("random", "nearest", "keywords", "gold")
    lacking = {"embeddings": "needs an extra"}
    whole = EndToEnd(dict.fromkeys(which, outcomes), about, facts, lacking)
    path = tmp_path_factory.mktemp("plans") / "table-3.json"
    path.write_text(with_validity(render(whole, "json", draws=20), None))
    return path


@pytest.fixture(scope="module")
def videos(corpus, tmp_path_factory):
    """A folder as ``ct render-videos`` makes them, of grey pictures."""
    folder = tmp_path_factory.mktemp("videos")
    (own := folder / "first").mkdir()
    frames = np.full((6, 48, 64, 3), 128, dtype=np.uint8)
    encode(frames, own / "video.mp4", size=(64, 48), fps=6, quality="draft")
    cv2.imwrite(str(own / "poster.png"), frames[0])
    name = next(iter(corpus.contexts))
    (own / "manifest.json").write_text(json.dumps({"id": name, "title": "It drives."}))
    square = [[10, 10], [30, 10], [30, 30], [10, 30]]
    things = [{"id": key, "polygons": [square]} for key in ("pallet", "truck")]
    seen = {"width": 64, "height": 48, "objects": things}
    (own / "segmentation.json").write_text(json.dumps(seen))
    return folder


@pytest.fixture(scope="module")
def report(corpus, plans, videos, tmp_path_factory):
    folder = tmp_path_factory.mktemp("reports")
    corpus.save(folder / "tiny")
    arguments = ["--report", str(folder / "out"), "--corpus", str(folder / "tiny")]
    arguments += ["--plans", str(plans), "--videos", str(videos), "--repeats", "1"]
    arguments += ["--draws", "20", "--json"]
    done = CliRunner().invoke(evaluate, arguments, catch_exceptions=False)
    assert done.exit_code == 0, done.output
    assert "report.html" in json.loads(done.stdout)["files"]
    return folder / "out"


def test_the_page_has_all_parts_and_needs_nothing_else(report):
    page = (report / "report.html").read_text()
    for part in ("table-3-1", "table-1", "learning", "table-2", "judge", "examples", "errors"):
        assert f'<section id="{part}">' in page
    assert "<script" not in page
    assert "&lt;script&gt;" not in page or ODD not in page
    assert "https://" not in page
    assert "tiny &lt;b&gt;" in page


def test_the_page_shows_what_a_model_has_to_beat(report):
    page = (report / "report.html").read_text()
    for row in ("random cost", "no model: the nearest load", "no model: keywords"):
        assert f"<td>{row}</td>" in page
    assert "no model: word embeddings (needs an extra)" in page
    assert "Commands in worlds with two loads or more" in page
    # All outcomes are fully known, so that this part is told once.
    assert "Commands whose outcome is fully known" not in page
    assert "Compared, table-3: all commands" in page


def test_a_table_without_baselines_makes_no_report(plans, tmp_path):
    document = json.loads(plans.read_text())
    document["rows"] = [r for r in document["rows"] if r["configuration"] != "keywords"]
    (tmp_path / "old.json").write_text(json.dumps(document))
    with pytest.raises(FormatError, match="no rows of keywords") as error:
        read_plans(tmp_path / "old.json")
    assert "run it again" in error.value.fix
    assert "ct eval table3" in error.value.fix


def test_a_table_by_another_judge_makes_no_report(plans, tmp_path):
    document = json.loads(plans.read_text())
    document["rows"] = [{**row, "judge": "llm"} for row in document["rows"]]
    (tmp_path / "other.json").write_text(json.dumps(document))
    with pytest.raises(FormatError, match="by the judge llm, and a report shows the automatic"):
        read_plans(tmp_path / "other.json")


def test_the_other_files_say_the_same(report, plans):
    found = json.loads((report / "report.json").read_text())
    rows = {row["type"]: row for row in found["table_1"]["rows"]}
    shown = csv.DictReader(io.StringIO((report / "table-1.csv").read_text()))
    for row in shown:
        f = rows[row["type"]]["f"]
        assert row["f"] == ("" if f is None else str(f))
    assert found["table_3"][0]["rows"] == json.loads(plans.read_text())["rows"]
    assert found["table_2"]["rows"][0]["precision"] == pytest.approx(2 / 3)
    assert found["judge_validity"]["n"] == 1
    assert found["provenance"]["corpus_hash"].startswith("sha256:")
    assert any(line.startswith("ct eval table1") for line in found["commands"])
    compared = csv.DictReader(io.StringIO((report / "table-3-comparisons.csv").read_text()))
    assert [(row["judge"], row["subset"], row["one"], row["n"]) for row in compared] == [
        ("automatic", subset, one, n)
        for subset, n in (("all", "10"), ("two-or-more", "6"))
        for one in ("random", "nearest", "keywords")
    ]
    for number in (1, 2, 3):
        assert r"\begin{tabular}" in (report / f"table-{number}.tex").read_text()
        assert (report / f"table-{number}.csv").is_file()


def test_a_report_is_replaced_and_nothing_else_is(report, tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    arguments = ["--report", str(tmp_path), "--corpus", "warehouse"]
    done = CliRunner().invoke(evaluate, arguments)
    assert done.exit_code == 1
    assert isinstance(done.exception, FormatError)
    assert (tmp_path / "mine.txt").read_text() == "mine"


@pytest.mark.parametrize(
    "wrong", [["--train", "warehouse"], ["--format", "csv"], ["--out", "x"], ["--models"]]
)
def test_what_does_not_go_with_it_is_refused(wrong, tmp_path):
    arguments = ["--report", str(tmp_path / "out"), "--corpus", "warehouse", *wrong]
    assert CliRunner().invoke(evaluate, arguments).exit_code == 2
    assert CliRunner().invoke(evaluate, ["--report", str(tmp_path / "out")]).exit_code == 2


def test_other_files_are_no_plans(tmp_path):
    for text in ('{"rows": 3}', "{}", "no JSON"):
        (tmp_path / "x.json").write_text(text)
        with pytest.raises(FormatError, match="no Table 3"):
            read_plans(tmp_path / "x.json")


def test_people_and_the_judge_are_read_apart(videos, tmp_path):
    row = {"configuration": "gold-all", "precision": 0.5, "low": 0.4, "high": 0.6, "n": 9}
    baselines = [{**row, "configuration": name} for name in ALONE]
    compared = {"one": "random", "other": "gold", "n": 9, "difference": -0.4, "effect": -1.0}
    compared |= {"low": -0.5, "high": -0.3, "p": 0.01, "adjusted_p": 0.03}
    plan = {"command": "c", "text": "Go.", "probability": 0.5, "reason": "it stands"}
    told = [{**plan, "correct": n == 0, "run": f"run-{n}"} for n in range(3)]
    study = {
        "table": 3,
        "study": str(tmp_path / "study.yaml"),
        "people": [{**row, "judge": "people", "n": 45}],
        "people_compared": [compared],
        "automatic": {
            "rows": [{**row, "judge": "automatic"}, *baselines],
            "comparisons": [{**compared, "n": 8}],
            "judge_validity": None,
        },
        "commands": {"gold": [{**one, "correct": int(one["correct"])} for one in told]},
    }
    shutil.copytree(videos / "first", tmp_path / "videos" / "run-2")
    (tmp_path / "study.json").write_text(json.dumps(study))
    found = read_plans(tmp_path / "study.json")
    assert [(r.judge, r.n) for r in found.file.rows] == [("automatic", 9)] * (1 + len(ALONE))
    assert [(r.judge, r.n) for r in found.file.people] == [("people", 45)]
    assert [c.n for c in (*found.file.people_compared, *found.file.comparisons)] == [9, 8]
    assert found.provenance == {"table": 3}
    # Of the two that are wrong one has a video.
    assert [f.plan.run for f in failures(found, 4)] == ["run-2"]


def test_bins_by_hand():
    n = 4
    said = Predictions(
        np.array(["OBJECT"] * n),
        np.array([True, False, True, True]),
        np.array([0.61, 0.69, 1.0, 0.05]),
        np.array(list("abcd")),
        np.array(list("stuv")),
    )
    low, middle, high = bins(said, seed=0, draws=50)
    assert (low.stated, low.true, low.n) == (0.05, 1.0, 1)
    assert (middle.stated, middle.true, middle.n) == (pytest.approx(0.65), 0.5, 2)
    assert (high.stated, high.true) == (1.0, 1.0)
    error = calibration_error((low, middle, high))
    assert error.value == pytest.approx((0.95 + 2 * 0.15 + 0.0) / 4)


def _texts(plot, width):
    root = ET.fromstring(plot.saved("svg", width))
    return [text.text for text in root.iter("{http://www.w3.org/2000/svg}text")]


@pytest.mark.parametrize("width", [WIDE, NARROW])
def test_differences_lie_on_both_sides_of_none(width):
    plot = differences([Line("a − b", {"right": Estimate(-0.5, -0.7, 0.1)})], "differences")
    assert {"a − b", "−0.50 (−0.70 to +0.10)", "−1", "0", "1"} <= {*_texts(plot, width)}
    (axes,) = plot.draw(width).axes
    assert axes.get_xlim() == (-1, 1)
    zero, whisker, point = (list(line.get_xdata()) for line in axes.lines)
    assert (zero, whisker, point) == ([0, 0], [-0.7, 0.1], [-0.5])


@pytest.mark.parametrize("width", [WIDE, NARROW])
def test_plots_show_text_as_text_and_what_is_unknown_as_a_dash(width):
    nan = float("nan")
    lines = [
        Line("<b>", {"x & y": Estimate(0.5, 0.4, 0.6)}, 0.9),
        Line("few", {"x & y": Estimate(0.5, nan, nan)}),
        Line("none", {"x & y": Estimate(nan, nan, nan)}),
    ]
    drawn = _texts(intervals(lines, "a & b"), width)
    assert {"<b>", "0.50 (0.40–0.60)", "0.50 (–)", "–"} <= {*drawn}
    assert "nan" not in " ".join(drawn)


def test_every_plot_is_a_file_for_papers(report):
    page = (report / "report.html").read_text()
    drawn = {path.stem for path in report.glob("*.svg")}
    assert {"table-1", "table-2", "table-3-all", "table-3-all-compared", "reliability"} <= drawn
    assert drawn == {path.stem for path in report.glob("*.pdf")}
    assert page.count("<svg role") == 2 * len(drawn)
    for pdf in report.glob("*.pdf"):
        assert pdf.read_bytes().startswith(b"%PDF")
        assert b"/Type3" not in pdf.read_bytes()  # which many venues refuse


def test_latex_says_what_it_needs_and_holds_no_paths(report):
    for path in report.glob("*.tex"):
        text = path.read_text()
        for table in text.split("\n\n"):
            assert table.startswith(r"% Needs \usepackage{booktabs}.")
            assert table.count(r"\begin{tabular}") == table.count(r"\end{tabular}") == 1
        assert str(report.parent) not in text


def test_new_worlds_come_first_and_names_are_told_apart(plans, tmp_path):
    document = json.loads(plans.read_text())
    for name, train, test in (("own", ["a"], "a"), ("other", ["a", "b"], "b"), ("new", ["a"], "c")):
        made = {**document, "train": train, "test": test, "test_scenarios": ["s", "t"]}
        (tmp_path / f"{name}.json").write_text(json.dumps(made))
    files = [tmp_path / f"{name}.json" for name in ("own", "other", "new")]
    found = read_all_plans(files, "a")
    assert [(p.name, p.is_new, len(p.file.test_scenarios)) for p in found] == [
        ("new", True, 2),
        ("other", False, 2),
        ("own", False, 2),
    ]
    with pytest.raises(FormatError, match="two files of plans are called own"):
        read_all_plans([files[0], files[0]], "a")


def test_the_papers_figures_are_not_beside_a_handful(report):
    assert [beside(0.9, n, is_authored=False) for n in (6, 9, 10)] == [None, None, 0.9]
    page = (report / "report.html").read_text()
    table = page[page.index('<section id="table-2">') :].partition("</table>")[0]
    assert re.findall('<td class="ref">([^<]*)</td>', table) == ["–", "–"]  # a pair of videos each
    rows = [line.split(" & ") for line in (report / "table-2.tex").read_text().splitlines()]
    assert {row[0]: row[3] for row in rows if len(row) > 1} == {
        "Video": "Paper", "original": "-", "random": "-"
    }  # fmt: skip


def measured(tmp_path_factory, corpus, judgments):
    """The texts of a report's page, of a corpus whose commands nobody typed for a video."""
    folder = tmp_path_factory.mktemp("authored")
    commands = {id_: replace(c, subject="authored") for id_, c in corpus.commands.items()}
    annotations = tuple(replace(a, command=commands[a.command.id]) for a in corpus.annotations)
    authored = replace(corpus, commands=commands, annotations=annotations, judgments=judgments)
    authored.save(folder / "authored")
    arguments = ["report", str(folder / "out"), "--corpus", str(folder / "authored")]
    done = CliRunner().invoke(evaluate, [*arguments, "--repeats", "0", "--draws", "20"])
    assert done.exit_code == 0, done.output
    return (folder / "out" / "report.html").read_text()


def test_the_papers_figures_are_not_beside_an_authored_corpus(tmp_path_factory, corpus):
    simulated = tuple(replace(j, study="simulated") for j in corpus.judgments)
    page = measured(tmp_path_factory, corpus, simulated)
    assert "diamonds are the paper" not in page
    assert '<th class="ref">' not in page
    table = page[page.index('<section id="table-2">') :]
    assert '<span class="by automatic">simulated raters</span>' in table
    assert '<section id="judge">' not in page


def test_nothing_is_shown_of_a_handful_of_judgments(tmp_path_factory, corpus):
    page = measured(tmp_path_factory, corpus, corpus.judgments[:4])
    assert '<section id="table-2">' not in page
    assert '<section id="judge">' not in page


def test_words_have_the_colour_of_what_they_name(corpus, videos):
    (shown,) = examples(corpus, videos, 3)
    assert "".join(words.text for words in shown.words) == shown.command
    coloured = {words.colour: words.text for words in shown.words if words.colour}
    assert coloured.keys() == {phrase.colour for phrase in shown.phrases}
    for phrase in shown.phrases:
        assert coloured[phrase.colour] in phrase.text


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_a_browser_shows_it_whole_narrow_and_wide(report, tmp_path: Path):
    playwright = pytest.importorskip("playwright.sync_api")
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    flags = ["--no-sandbox", "--headless", "--disable-gpu", "--no-first-run"]
    address = (report / "report.html").as_uri()
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=flags)
        problems: list[str] = []
        asked: list[str] = []
        for width in (360, 1200):
            page = browser.new_page(viewport={"width": width, "height": 800})
            page.on("console", lambda m: problems.append(m.text) if m.type == "error" else None)
            page.on("request", lambda r: asked.append(r.url.split(",")[0]))
            page.goto(address)
            page.wait_for_function("document.querySelector('video').readyState >= 1")
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            page.screenshot(path=tmp_path / f"report-{width}.png", full_page=True)
        # axe's own script is what the page's policy refuses, so it is looked at without.
        for scheme in ("light", "dark"):
            page = browser.new_context(bypass_csp=True, color_scheme=scheme).new_page()
            page.goto(address)
            found = axe.Axe().run(page).response["violations"]
            assert [v["id"] for v in found] == [], scheme
        assert problems == []
        assert all(url == address or url.startswith("data:") for url in asked)
        browser.close()
