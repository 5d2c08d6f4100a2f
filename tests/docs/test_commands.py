"""Every command in the documentation is one that there is, and is run, here or elsewhere."""

from __future__ import annotations

import bz2
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import click
import pytest

from corpus_tools.cli.console import cli, run
from g3.errors import FormatError
from tests.corpus_tools.importers.path_phrases import put_phrases
from tests.corpus_tools.importers.random_tasks import put_world
from tests.docs.blocks import ROOT, Shown, alike, shown
from tests.docs.small_warehouse import SOURCE, small_warehouse

SHOWN = shown()

ELSEWHERE = {
    r"ct eval table1 .*--(write-tasks|predictions)": (
        "tests/eval/table_1/test_given_predictions.py",
        "needs a form that is filled in",
    ),
    r"ct eval judge-validity .*--judge": (
        "tests/eval/judging/test_judge_validity.py",
        "needs another judge",
    ),
    r"ct import tabletop-blocks|.*\bblocks(\.npz)?\b": (
        "tests/examples/test_tabletop_blocks.py",
        "needs the example installed",
    ),
    r".*cable_reel": ("tests/examples/test_cable_reel.py", "needs the example installed"),
    r".*examples/paraphrase": ("tests/examples/test_paraphrase.py", "needs the example installed"),
    r"ct render-videos|.* && ct render-videos": (
        "tests/corpus_tools/video/test_render_commands.py",
        "minutes",
    ),
    r"ct annotate --studies": (
        "tests/annotation_app/making/test_lab_in_browser.py",
        "serves",
    ),
    r"ct annotate( serve)?( [\w/-]+\.yaml.*)?$": (
        "tests/annotation_app/cli/test_annotate_commands.py",
        "serves",
    ),
    r"ct annotate init .*--videos": (
        "tests/annotation_app/study_setup/test_own_videos.py",
        "needs videos",
    ),
    r"ct corpus export .*--videos": (
        "tests/corpus_tools/exporters/test_lerobot_episodes.py",
        "needs videos",
    ),
    r"ct import (lerobot|robomimic|rlds|rosbag)": (
        "tests/corpus_tools/lerobot/test_study_input.py",
        "needs a dataset",
    ),
    r"ct eval subtasks": (
        "tests/annotation_app/study_setup/test_corrected_steps.py",
        "needs a study with answers",
    ),
    r"ct annotate (export|import)": (
        "tests/annotation_app/cli/test_annotate_commands.py",
        "needs a study with answers",
    ),
    r"ct (corpus stats|train parser --corpus) drone": (
        "tests/annotation_app/export/test_trees_of_videos.py",
        "needs a study with answers",
    ),
    r"ct annotate (backup|verify|restore)": (
        "tests/annotation_app/copies/test_damaged_backups.py",
        "needs a study with answers",
    ),
    r"ct annotate people erase": ("tests/annotation_app/privacy/test_erasure.py", "needs a study"),
    r"ct crowd": (
        "tests/annotation_app/crowds/mturk/test_paying.py",
        "needs a platform",
    ),
    r"ct annotate (people|audit|check)": (
        "tests/annotation_app/cli/test_people_commands.py",
        "changes an installation",
    ),
    r"ct annotate tokens": (
        "tests/annotation_app/cli/test_program_commands.py",
        "needs a study",
    ),
    r"ct annotate copy-media": (
        "tests/annotation_app/copies/test_media_copies.py",
        "needs a study",
    ),
    r"ct shards|ct train g3 --shards": (
        "tests/corpus_tools/shards/test_shards.py",
        "a large corpus",
    ),
    r"ct demo": ("tests/eval/cli/test_demo.py", "three minutes"),
    r"ct eval end-to-end": ("tests/eval/plan_study/test_plan_study.py", "half an hour"),
    r"ct eval table3": ("tests/eval/table_3/test_end_to_end.py", "minutes"),
    r"ct eval report": ("tests/eval/report/test_report.py", "needs plans and videos"),
    r"ct eval table2 .* (--models|--study)": (
        "tests/eval/table_2/test_table_2.py",
        "needs more judgments than the small corpus has",
    ),
    r"ct eval power": ("tests/eval/statistics/test_power.py", "simulates studies for seconds"),
    r"ct (eval sdc|train parser) .*treebank": (
        "tests/eval/parsing/test_divisions.py",
        "trains on 3 200 commands",
    ),
    r"ct eval sdc .*--parser llm": (
        "tests/eval/language_model/test_language_model_parser.py",
        "needs a language model",
    ),
    r"ct eval sdc .* --train warehouse$": (
        "tests/eval/parsing/test_sdc_scores.py",
        "trains several times",
    ),
    r"ct simulate-workers describe|ct .*(simulated|rated)": (
        "tests/corpus_tools/simulation/test_commands.py",
        "physics of twenty scenarios",
    ),
    r"ct follow": ("tests/corpus_tools/cli/test_follow_commands.py", "trains for a minute"),
    r"ct scenarios naming-sheet": (
        "tests/corpus_tools/video/test_naming_sheet.py",
        "draws sixty pictures",
    ),
    r"ct scenarios log": ("tests/corpus_tools/world/scenarios/test_scenario_logs.py", "physics"),
}
"""What isn't run here, the file that runs the like, and why."""


TUTORIALS = {
    "docs/tutorial.md": "tests/docs/test_tutorial.py",
    "docs/tutorial-episodes.md": "tests/docs/test_tutorial_episodes.py",
}
SCENARIOS = ("dock_pick_up_tires", "dock_go_to_receiving", "yard_put_boxes_down_on_trailer")


def elsewhere(command: Shown) -> tuple[str, str] | None:
    if command.page in TUTORIALS and command.output is None:
        return (TUTORIALS[command.page], "its steps build on each other")
    if not command.calls:
        return (".ci/run", "no command of ct, and it changes the machine")
    return next((why for form, why in ELSEWHERE.items() if re.match(form, command.text)), None)


HERE = list({(c.text, c.output): c for c in SHOWN if elsewhere(c) is None}.values())
"""What is run here, each command once."""


def named(commands: list[Shown]) -> list[object]:
    return [pytest.param(c, id=f"{c.page}:{c.line}: {c.text[:60]}") for c in commands]


@pytest.mark.parametrize("command", named([c for c in SHOWN if c.calls]))
def test_every_command_has_the_options_that_are_shown(command: Shown) -> None:
    for call in command.calls:
        if call[:2] == ["import", "tabletop-blocks"]:
            continue
        try:
            parse(cli, call)
        except (click.BadParameter, FormatError) as error:  # what earlier commands make is missing
            assert re.search("there is no ", str(error))  # noqa: PT017


def parse(command: click.Command, args: list[str]) -> None:
    with command.make_context("ct", list(args), obj={}) as ctx:
        words = [*ctx._protected_args, *ctx.args]
        if isinstance(command, click.Group) and (words or not command.invoke_without_command):
            _, sub, rest = command.resolve_command(ctx, words)
            assert sub is not None
            parse(sub, rest)


def test_what_is_run_elsewhere_is() -> None:
    for file, _ in ELSEWHERE.values():
        assert (ROOT / file).is_file(), file
    for form in ELSEWHERE:
        assert any(re.match(form, c.text) for c in SHOWN), f"nothing is like {form}"


@pytest.fixture(scope="module")
def workshop(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with what the pages take to be there, much smaller than it really is.

    A folder called warehouse goes before the corpus that comes along.
    """
    folder = tmp_path_factory.mktemp("workshop")
    shutil.copytree(ROOT / "tests/data/slu_core_small", folder / "slu_core")
    data = folder / "slu_core" / "data"
    put_world(data / "corpusCommandsForVideoSmallFilesOnly" / "forklift.automatic.v1")
    put_phrases(data / "spatial_relations")
    small = small_warehouse(folder / "datasets/warehouse", SCENARIOS)
    (folder / "warehouse").symlink_to(small)
    shutil.copy(SOURCE / f"scenarios/{SCENARIOS[0]}.yaml", folder / "my-scenario.yaml")
    tags = (ROOT / "g3/language/similarity/warehouse_tags.txt").read_bytes()
    (folder / "tags.txt.bz2").write_bytes(bz2.compress(tags))
    before = Path.cwd()
    os.chdir(folder)
    yield folder
    os.chdir(before)


@pytest.mark.usefixtures("short_training")
@pytest.mark.parametrize("command", named(HERE))
def test_every_command_does_what_is_shown(
    command: Shown, workshop: Path, capfd: pytest.CaptureFixture[str], monkeypatch
) -> None:
    for name, value in re.findall(r"(\b[A-Z_]+)=(\S+)", command.text.partition("ct ")[0]):
        monkeypatch.setenv(name, value)
    statuses = {run(call) for call in command.calls}
    said = capfd.readouterr()
    if command.output is None:
        assert statuses == {0}, said.err
    else:
        assert (said.out + said.err).strip() == command.output.strip()


FOLLOWED = [c for c in SHOWN if c.output is not None and c.text.startswith("ct follow")]


def test_every_output_is_compared() -> None:
    assert FOLLOWED
    assert {c.text for c in SHOWN if c.output} == {c.text for c in (*FOLLOWED, *HERE) if c.output}


@pytest.mark.parametrize("command", named(FOLLOWED))
def test_commands_are_followed_as_is_shown(
    command: Shown, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the bundled corpus's model, which is kept; without the video, which takes minutes."""
    monkeypatch.chdir(ROOT)  # not where a small corpus goes before the bundled one
    ((*call,),) = command.calls
    output = command.output or ""
    if "--video" in call:
        place = call.index("--video")
        del call[place : place + 2]
        output = re.sub("^wrote .*", "", output, flags=re.MULTILINE)
    with suppress(SystemExit):  # nothing is done
        run(call)
    said = capfd.readouterr()
    assert alike(output, said.out + said.err), said
