"""Damaged files for every reader: each is refused by name, or means what was written.

``python -m tests.fuzz`` makes 3 500 of them, each reader in a process of its own, and prints what
came of them. It exits with 1 if a reader failed otherwise than by a named error, took damage for
another meaning, or needed 1 GiB. ``tests/test_fuzz.py`` tries some in the suite.

A reader is a row of `READERS`. It reads a whole folder of files, of which one is damaged at a time.
Its meaning is anything that can be compared; None where only errors can be judged.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import io
import json
import logging
import multiprocessing
import resource
import shutil
import sys
import tempfile
import time
import zlib
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

from tests.damage import damaged

MOST_BYTES = 1 << 30
LONGEST_S = 20.0
KEPT = 10
"""So many failures of a reader are kept."""


@dataclass(frozen=True, slots=True)
class Reader:
    """A reader of files."""

    make: Callable[[Path], Sequence[str]]
    """Writes what is valid into a folder, and returns the names of the files to damage."""
    read: Callable[[Path], Any]
    """Reads the folder; gives its meaning, None if that can't be compared."""
    write: Callable[[Any, Path], None] | None = None
    """Writes a meaning into a folder as `make` does. Without it the files have digests: damage
    must not be accepted with another meaning than the first."""


@dataclass(slots=True)
class Outcome:
    """What became of the damaged files of a reader."""

    tried: int = 0
    refused: int = 0
    accepted: int = 0
    unexpected: int = 0
    misread: int = 0
    peak_mb: int = 0
    slowest_s: float = 0.0
    failures: list[str] = field(default_factory=list)

    @property
    def is_fine(self) -> bool:
        """Whether nothing went wrong."""
        is_small = self.peak_mb << 20 < MOST_BYTES
        return not (self.unexpected or self.misread) and is_small and self.slowest_s < LONGEST_S


def fuzz(name: str, count: int, *, seed: int = 0) -> Outcome:
    """Try `count` damaged inputs of a reader."""
    from g3.errors import CorpusError

    reader, outcome = READERS[name], Outcome()
    with tempfile.TemporaryDirectory() as scratch, quiet():
        folder, other = Path(scratch) / "made", Path(scratch) / "again"
        folder.mkdir()
        files = [file for file in reader.make(folder) if (folder / file).stat().st_size]
        expected = reader.read(folder)
        each = -(-count // len(files))
        for file in files:
            original = (folder / file).read_bytes()
            some = damaged(original, 2 * each, seed=seed + zlib.crc32(file.encode()))
            for what, content in islice(some, each):
                outcome.tried += 1
                (folder / file).write_bytes(content)
                begun = time.monotonic()
                try:
                    found = reader.read(folder)
                except (CorpusError, OSError) as error:
                    outcome.refused += 1
                    if not _is_named(error, folder):
                        outcome.unexpected += 1
                        _keep(outcome, f"{file}: {what}: not named: {error!r}", content)
                except BaseException as error:
                    outcome.unexpected += 1
                    _keep(outcome, f"{file}: {what}: {type(error).__name__}: {error}", content)
                else:
                    outcome.accepted += 1
                    if not _is_same(reader, found, expected, other):
                        outcome.misread += 1
                        _keep(outcome, f"{file}: {what}: another meaning", content)
                outcome.slowest_s = max(outcome.slowest_s, time.monotonic() - begun)
            (folder / file).write_bytes(original)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    outcome.peak_mb = peak >> (20 if sys.platform == "darwin" else 10)
    return outcome


def _is_same(reader: Reader, found: Any, expected: Any, other: Path) -> bool:
    """Whether an accepted meaning is the first one or, without digests, stays when written anew."""
    if expected is None or found == expected:
        return True
    if reader.write is None:
        return False
    shutil.rmtree(other, ignore_errors=True)
    other.mkdir()
    reader.write(found, other)
    return bool(reader.read(other) == found)


def _is_named(error: Exception, folder: Path) -> bool:
    """Whether an error says in which file, or what file, something is wrong."""
    return str(folder) in str(error) or bool(getattr(error, "where", ""))


def _keep(outcome: Outcome, what: str, content: bytes) -> None:
    if len(outcome.failures) < KEPT:
        start = content[:200] if len(content) < 2000 else b""
        outcome.failures.append(f"{what[:400]} {start!r}")


@contextlib.contextmanager
def quiet() -> Any:
    """Let readers print nothing."""
    logging.disable(logging.CRITICAL)
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            yield
    finally:
        logging.disable(logging.NOTSET)


def _by_command(*arguments: str) -> Callable[[Path], None]:
    """A reader that is a command: ``{}`` stands for the folder. It must exit with 0 or 2."""

    def read(folder: Path) -> None:
        from corpus_tools.cli.console import run
        from g3.errors import CorpusError

        told = io.StringIO()
        with contextlib.redirect_stderr(told), contextlib.redirect_stdout(told):
            status = run([part.format(folder) for part in arguments])
        text = told.getvalue()
        if "unexpected error" in text or "not enough memory" in text or status not in (0, 2):
            raise RuntimeError(f"status {status}: {text[:600]}")
        if status == 2:
            raise CorpusError(text[:600], where=str(folder))

    return read


# What is made and read; all imports wait, so that each process holds only what its reader needs.
# ruff: noqa: PLC0415


def _make_corpus(folder: Path) -> list[str]:
    from tests.tiny_corpus import rated_corpus

    corpus = rated_corpus()
    corpus.save(folder / "c")
    return [f"c/{name}" for name in corpus.files()]


def _read_corpus(folder: Path) -> Any:
    from corpus_tools.corpus.corpus_model import Corpus

    return Corpus.load(folder / "c").files()


def _make_model(folder: Path) -> list[str]:
    from g3.learning.examples import examples
    from g3.learning.grounding_model import GroundingModel
    from tests.tiny_corpus import rated_corpus

    card: Any = {"scenarios": ("a", "b"), "training": {"seed": 3}}
    items = examples(rated_corpus().annotations)
    GroundingModel(card=card).fit(items).save(folder / "g3.npz")
    return ["g3.npz", "g3.json"]


def _read_model(folder: Path) -> Any:
    from g3.learning.grounding_model import GroundingModel
    from g3.learning.model_file import read_card

    loaded = GroundingModel.load(folder / "g3.npz")
    assert loaded.space_ is not None
    return read_card(folder / "g3.npz"), loaded.space_.keys.tobytes(), loaded.weights_.tobytes()


def _make_parser(folder: Path) -> list[str]:
    from g3.language.parsing.sdc_parser import default_parser

    default_parser().save(folder / "parser.npz")
    return ["parser.npz"]


def _read_parser(folder: Path) -> Any:
    from g3.language.parsing.parser_file import to_bytes
    from g3.language.parsing.sdc_parser import SDCParser

    found = SDCParser.load(folder / "parser.npz")
    return to_bytes(found.arcs_, found.card_, found.encoder_)


def _make_tags(folder: Path) -> list[str]:
    from g3.language.similarity.cooccurrence import count_list, table_to_bytes

    table = table_to_bytes(count_list(["truck tire", "truck trailer", "dog"]))
    (folder / "t.npz").write_bytes(table)
    return ["t.npz"]


def _read_tags(folder: Path) -> Any:
    from g3.language.similarity.cooccurrence import table_from_bytes, table_to_bytes

    path = folder / "t.npz"
    return table_to_bytes(table_from_bytes(path.read_bytes(), where=str(path), fix="count again"))


@functools.cache
def _instance() -> bytes:
    """A backup of an installation with people and studies."""
    from annotation_app.copies.backups import back_up
    from annotation_app.core.config import open_instance
    from annotation_app.people.participants import add_person
    from annotation_app.serving import server
    from annotation_app.store.audit import note
    from annotation_app.store.database import opened, transaction
    from annotation_app.store.models import Study

    with tempfile.TemporaryDirectory() as scratch:
        config = open_instance(Path(scratch) / "instance")
        server.prepare(config)
        from annotation_app.serving.factory import create_app

        with opened(config.database) as engine:
            app = create_app(config, engine)
            with app.app_context(), transaction(engine) as session:
                for name in ("one", "other"):
                    study: dict[str, Any] = {"name": name, "title": "A title", "tasks": {}}
                    session.add(Study(id=name, name=name, config=study, created_at=1.5))
                    person = add_person(session, "test", f"{name} 0123")
                    note(session, "tests", "added", person.id, role="worker")
        back_up(config, Path(scratch) / "b.gz", None)
        return (Path(scratch) / "b.gz").read_bytes()


def _make_backup(folder: Path) -> list[str]:
    (folder / "b.jsonl.gz").write_bytes(_instance())
    return ["b.jsonl.gz"]


def _read_backup(folder: Path) -> Any:
    from annotation_app.copies.restoring import verify

    found = verify(folder / "b.jsonl.gz")
    return dict(found.counts), found.sha256, found.head


_DATASET = Path(__file__).resolve().parents[1] / "datasets/warehouse"
_SCENARIO = "dock_pick_up_tires"


def _make_log(folder: Path) -> list[str]:
    shutil.copy(_DATASET / f"logs/{_SCENARIO}.mcap", folder / "log.mcap")
    return ["log.mcap"]


def _read_log(folder: Path) -> Any:
    from corpus_tools.logs.log_reading import read_log

    log = read_log(folder / "log.mcap")
    found = log.recording
    arrays = (found.t_ns, found.position, found.orientation, found.fork_height_m)
    world = [(o.id, o.labels, o.prism.xy.tobytes()) for o in found.start.objects]
    return log.name, dict(log.metadata), [a.tobytes() for a in arrays], found.steps, world


def _make_scenario(folder: Path) -> list[str]:
    shutil.copytree(_DATASET / "layouts", folder / "layouts")
    (folder / "scenarios").mkdir()
    shutil.copy(_DATASET / f"scenarios/{_SCENARIO}.yaml", folder / "scenarios/s.yaml")
    (layout,) = (
        line.partition(": ")[2]
        for line in (folder / "scenarios/s.yaml").read_text().splitlines()
        if line.startswith("layout: ")
    )
    return ["scenarios/s.yaml", f"layouts/{layout}.yaml"]


def _read_scenario(folder: Path) -> Any:
    from corpus_tools.world.scenarios.scenario_files import format_scenario
    from corpus_tools.world.scenarios.scenario_reading import read_scenario

    return format_scenario(read_scenario(folder / "scenarios/s.yaml"))


def _write_scenario(found: Any, folder: Path) -> None:
    shutil.copytree(_DATASET / "layouts", folder / "layouts")
    (folder / "scenarios").mkdir()
    (folder / "scenarios/s.yaml").write_text(found)


_STUDY = """\
name: load
title: A load
videos: clips
access: invited
robot: arm
tasks:
  describe: {answers: 3, lease_minutes: 20, practice: false}
  rate: {answers: 5, lease_minutes: 20.5}
consent: |
  You will watch short videos.
questions:
  - {id: english, text: Is it?, choices: ["Yes", "No"]}
qualification:
  - I am at least 18 years old.
payment: {amount: 0.25, currency: USD}
"""


def _make_study(folder: Path) -> list[str]:
    (folder / "s.yaml").write_text(_STUDY)
    return ["s.yaml"]


def _read_study(folder: Path) -> Any:
    import msgspec

    from annotation_app.study_setup.study_reading import read_study

    return msgspec.to_builtins(read_study(folder / "s.yaml"), str_keys=True)


def _write_study(found: Any, folder: Path) -> None:
    from annotation_app.study_setup.study_drafts import to_yaml

    (folder / "s.yaml").write_bytes(to_yaml(found))


_NOTATION = (
    "EVENT_1(r = Put, l = OBJ_2(f = the pallet), l2 = PLACE_3(r = on, l = OBJ_4(f = the truck)))\n"
    'EVENT_5(r = Go, l = PATH_6(r = to, l = OBJ_7(f = the \\"red\\" truck)))\n'
)


def _make_notation(folder: Path) -> list[str]:
    from g3.sdc.sdc_notation import format_brackets, parse_brackets

    (folder / "n.sdc").write_text(format_brackets(parse_brackets(_NOTATION.replace('\\"', ""))))
    return ["n.sdc"]


def _read_notation(folder: Path) -> Any:
    from g3.errors import SDCError
    from g3.sdc.sdc_notation import format_brackets, parse_brackets

    try:
        return format_brackets(parse_brackets((folder / "n.sdc").read_bytes().decode()))
    except (SDCError, UnicodeDecodeError) as error:  # the command names the file
        raise SDCError(str(error), where=str(folder)) from error


def _write_notation(found: Any, folder: Path) -> None:
    (folder / "n.sdc").write_text(found)


def _make_small_files(folder: Path) -> list[str]:
    """The key file, the list of people who were erased, and the answers of raters."""
    from annotation_app.core.key_file import new_keys, write_keys

    write_keys(folder / "secret-key", new_keys())
    lines = [json.dumps({"person": f"p{i}", "at": 1.5 + i}) for i in range(5)]
    (folder / "erased.jsonl").write_text("\n".join(lines) + "\n")
    return ["erased.jsonl", "secret-key"]


def _read_small_files(folder: Path) -> Any:
    from annotation_app.core.key_file import read_keys
    from annotation_app.store.tombstones import read_tombstones

    keys = read_keys(folder / "secret-key")
    erased = [(one.person, one.at) for one in read_tombstones(folder / "erased.jsonl")]
    return keys.secret, keys.salt, erased


def _write_small_files(found: Any, folder: Path) -> None:
    from annotation_app.core.key_file import Keys, write_keys

    secret, salt, erased = found
    write_keys(folder / "secret-key", Keys(secret, salt))
    lines = [json.dumps({"person": person, "at": at}) + "\n" for person, at in erased]
    (folder / "erased.jsonl").write_text("".join(lines))


def _make_tables(folder: Path) -> list[str]:
    """A study of two videos with a table of them, commands for them, and things in them."""
    from tests.annotation_app.study_setup.clips import HEIGHT, WIDTH, clip

    for name in ("push", "lift"):
        clip(folder / f"{name}.mp4", 40)
    (folder / "videos.csv").write_text(
        'video,id,place,note\npush.mp4,a,"kitchen, left",1\nlift.mp4,b,hall,"say ""go"""\n'
    )
    rows = [{"video": "push.mp4", "command": "Push it."}, {"video": "lift.mp4", "command": "Ü"}]
    (folder / "commands.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    size = {"width": WIDTH, "height": HEIGHT}
    box = {"category_id": 1, "bbox": [2, 3, 20, 30]}
    mask = {"size": [HEIGHT, WIDTH], "counts": [100, 4, HEIGHT * WIDTH - 104]}
    coco = {
        "images": [
            {"id": 1, "file_name": "a.png", **size},
            {"id": 2, "file_name": "b.png", **size},
        ],
        "annotations": [
            {"id": 17, "image_id": 1, **box, "segmentation": [[2, 3, 22, 3, 22, 33]]},
            {"id": 18, "image_id": 2, **box, "segmentation": mask},
        ],
        "categories": [{"id": 1, "name": "cup"}],
    }
    (folder / "things.json").write_text(json.dumps(coco))
    study = {
        "name": "arm", "title": "An arm", "videos": "videos.csv", "commands": "commands.jsonl",
        "things": "things.json",
        "tasks": {task: {"practice": False} for task in ("describe", "segment", "ground")},
    }  # fmt: skip
    (folder / "arm.yaml").write_text(json.dumps(study))
    return ["videos.csv", "commands.jsonl", "things.json"]


def _make_lerobot(folder: Path, *, is_new: bool) -> list[str]:
    from tests.lerobot_datasets import new_dataset, old_dataset

    (new_dataset if is_new else old_dataset)(folder / "dataset")
    found = (folder / "dataset").rglob("*")
    kept = [p for p in found if p.suffix in (".json", ".jsonl", ".parquet")]
    return sorted(str(path.relative_to(folder)) for path in kept)


def _make_robomimic(folder: Path) -> list[str]:
    from tests.corpus_tools.episodes.test_robomimic import dataset

    return [dataset(folder / "dataset.hdf5").name]


def _make_rlds(folder: Path) -> list[str]:
    from tests.rlds_datasets import dataset

    files = dataset(folder / "dataset").iterdir()
    return sorted(str(path.relative_to(folder)) for path in files)


def _make_mcap(folder: Path) -> list[str]:
    from tests.corpus_tools.episodes.test_rosbag import protobuf

    return [protobuf(folder / "dataset").name]


def _episodes(command: str, name: str) -> Callable[[Path], Any]:
    return _by_command("import", command, f"{{0}}/{name}", "--out", "{0}/out", "--force")


_LEROBOT = _by_command("import", "lerobot", "{0}/dataset", "--out", "{0}/out", "--force")
READERS: dict[str, Reader] = {
    "corpus": Reader(_make_corpus, _read_corpus),
    "model": Reader(_make_model, _read_model),
    "parser": Reader(_make_parser, _read_parser),
    "tag table": Reader(_make_tags, _read_tags),
    "backup": Reader(_make_backup, _read_backup),
    "log": Reader(_make_log, _read_log),
    "scenario": Reader(_make_scenario, _read_scenario, _write_scenario),
    "study": Reader(_make_study, _read_study, _write_study),
    "notation": Reader(_make_notation, _read_notation, _write_notation),
    "keys and erasures": Reader(_make_small_files, _read_small_files, _write_small_files),
    "tables and COCO": Reader(_make_tables, _by_command("annotate", "check", "{0}/arm.yaml")),
    "LeRobot 3.0": Reader(functools.partial(_make_lerobot, is_new=True), _LEROBOT),
    "LeRobot 2.1": Reader(functools.partial(_make_lerobot, is_new=False), _LEROBOT),
    "HDF5": Reader(_make_robomimic, _episodes("robomimic", "dataset.hdf5")),
    "RLDS": Reader(_make_rlds, _episodes("rlds", "dataset")),
    "MCAP": Reader(_make_mcap, _episodes("rosbag", "dataset.mcap")),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Try all readers, or those that are named, and print a table."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("readers", nargs="*", metavar="READER", help=f"of: {', '.join(READERS)}")
    parser.add_argument("--count", type=int, default=220, help="damaged inputs for each reader")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args(arguments)
    names = options.readers or list(READERS)
    out, total = sys.stdout.write, Counter[str]()
    columns = ("tried", "refused", "accepted", "unexpected", "misread", "peak_mb", "slowest_s")
    out(f"{'reader':20}" + "".join(f"{name:>11}" for name in columns) + "\n")
    failures, is_fine = [], True
    context = multiprocessing.get_context("spawn")
    with context.Pool(options.jobs, maxtasksperchild=1) as pool:
        work = functools.partial(fuzz, count=options.count, seed=options.seed)
        for name, outcome in zip(names, pool.imap(work, names), strict=True):
            figures = asdict(outcome)
            cells = (f"{figures[column]:>11.4g}" for column in columns)
            out(f"{name:20}{''.join(cells)}\n")
            sys.stdout.flush()
            total.update({c: figures[c] for c in columns[:5]})
            failures += [f"{name}: {failure}" for failure in outcome.failures]
            is_fine &= outcome.is_fine
    out(f"{'all':20}" + "".join(f"{total[column]:>11}" for column in columns[:5]) + "\n")
    for failure in failures:
        out(f"{failure}\n")
    return 0 if is_fine else 1


if __name__ == "__main__":
    sys.exit(main())
