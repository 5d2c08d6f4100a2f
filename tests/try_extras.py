"""Try what each extra promises, and what is said without it, in empty virtual environments.

Needs a network and some minutes, so it is no test of the suite::

    pip wheel --no-deps --wheel-dir dist .
    python tests/try_extras.py dist/*.whl
    python tests/try_extras.py dist/*.whl --python 3.12 --extra render --extra app
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tests.lerobot_datasets import new_dataset  # noqa: E402 - as above
from tests.tiny_corpus import tiny_corpus  # noqa: E402 - runs as a script

EXTRAS = (
    "study", "plot", "language", "render", "parquet", "app", "cluster", "embeddings",
    "llm", "hdf5", "hub", "rlds", "ros",
)  # fmt: skip
CONTAINER = "--instance data/annotation --studies data/studies --https --proxies 1"
SMALL = "--size 160x120 --fps 4 --quality draft"


@dataclass(frozen=True)
class Trial:
    """A line, the extras that it needs, and what is to be seen with and without them.

    Parameters
    ----------
    needs
        Extras; none for what the core does.
    tells
        Whether one of them is named where it is missing.
    runs
        Whether it can be run where they are there.
    serves
        Whether it goes on until it is ended.
    """

    needs: tuple[str, ...]
    line: str
    tells: bool = True
    runs: bool = True
    serves: bool = False


TRIALS = (
    Trial((), "ct --help"),
    Trial((), "ct doctor corpora disk wordnet image-tags"),
    Trial((), "ct completion bash"),
    Trial((), "ct graph 'OBJ(f = it)' --json"),
    Trial((), "ct corpus validate warehouse"),
    Trial((), "ct features list --json"),
    Trial((), "ct similarity show skid --label pallet"),
    Trial((), "ct scenarios generate --seed 1 --count 2 --out made"),
    Trial((), "ct scenarios check made"),
    Trial((), "ct simulate-workers rate --corpus tiny --out rated-too"),
    Trial((), "ct train g3 --corpus tiny --out tiny.npz"),
    Trial((), "ct eval table1 --corpus tiny --cv scenario --json"),
    Trial((), "ct eval table2 --corpus rated"),
    Trial(
        ("plot",),
        "ct eval learning-curve --corpus tiny --cv scenario --repeats 1 --out c.svg",
        tells=False,
    ),
    Trial(("study",), "ct eval table2 --corpus rated --models"),
    Trial(("study",), "ct eval report report --corpus tiny --repeats 0", tells=False),
    Trial((), "ct parse 'Go to the truck'"),
    Trial(("language",), "ct doctor parsing"),
    Trial(("language",), "ct parse 'Lift it' --format conllu"),
    Trial(("render",), f"ct render-videos --corpus tiny --only to_truck* --out v {SMALL}"),
    Trial(("render",), "ct scenarios log hall_pick_up_boxes --dataset copy"),
    Trial(("render",), "ct doctor drawing encoding"),
    Trial((), "ct shards tiny --out shards"),
    Trial((), "ct train g3 --shards shards --out sharded.npz", tells=False),
    Trial((), "ct annotate init my-study.yaml"),
    Trial(("app",), "ct annotate import tiny --videos videos --instance lab"),
    Trial(("app",), "ct annotate export answers.csv --format csv --instance lab"),
    Trial(("app",), "ct crowd publish links tiny --url https://lab.example.org --instance lab"),
    Trial(("app",), "ct annotate backup copy.gz --instance lab --without-keys"),
    Trial(("app",), "ct doctor database"),
    Trial(("app",), "ct annotate check study.yaml --instance lab"),
    Trial(("app",), "ct annotate serve study.yaml --instance lab --port 0", serves=True),
    Trial(("app",), "ct annotate --instance lab --port 0", serves=True),
    # As the container does, and the demo, whose videos are made first.
    Trial(("app",), f"ct annotate serve --port 0 {CONTAINER}", serves=True),
    Trial(("app", "render"), "ct annotate --demo --port 0", serves=True),
    Trial(("parquet", "render"), "ct import lerobot episodes --out tables"),
    Trial(("hub",), "ct import lerobot --repo-id no/such --out from-hub", tells=False, runs=False),
    Trial(
        ("render", "cluster"),
        f"ct render-videos --corpus tiny --out v {SMALL} --scheduler tcp://127.0.0.1:1",
        runs=False,
    ),
)


def main(arguments: Sequence[str]) -> int:
    """Try the extras, and tell what is not as promised."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("wheel", type=Path)
    parser.add_argument("--python", default=f"{sys.version_info[0]}.{sys.version_info[1]}")
    parser.add_argument("--extra", action="append", metavar="EXTRA[,EXTRA]")
    parser.add_argument("--folder", type=Path, help="kept, rather than a new one for each run")
    given = parser.parse_args(arguments)
    extras = ["", *EXTRAS, ",".join(EXTRAS)]
    with tempfile.TemporaryDirectory() as scratch:
        folder = given.folder or Path(scratch)
        wrong = [w for e in given.extra or extras for w in try_extra(e, given, folder)]
    print(*wrong or ["all as promised"], sep="\n")  # noqa: T201
    return 1 if wrong else 0


def try_extra(extra: str, given: argparse.Namespace, folder: Path) -> list[str]:
    """What isn't as promised with an extra, or several with commas."""
    work = folder / f"{Path(given.python).name}-{extra or 'core'}"
    work.mkdir(parents=True)
    bin_folder = work / "venv/bin"
    wheel = str(given.wheel.resolve()) + (f"[{extra}]" if extra else "")
    for line in (
        ["uv", "venv", "--quiet", "--python", given.python, str(work / "venv")],
        ["uv", "pip", "install", "--quiet", "--python", str(bin_folder / "python"), wheel],
    ):
        subprocess.run(line, check=True)
    tiny_corpus().save(work / "tiny")
    shutil.copytree(ROOT / "datasets/warehouse", work / "copy")
    ours = Path(sys.executable).with_name("ct")
    for line in (
        f"render-videos --corpus tiny --out videos {SMALL}",
        "simulate-workers rate --corpus tiny --out rated",
    ):
        command = [str(ours), *shlex.split(line)]
        subprocess.run(command, check=True, cwd=work, stdout=subprocess.DEVNULL)
    tasks = {"describe": {"answers": 1, "practice": False}}
    study = {"name": "small", "title": "Small", "videos": "videos", "tasks": tasks}
    (work / "study.yaml").write_text(json.dumps(study))
    (work / "data").mkdir()
    new_dataset(work / "episodes")
    environment = {
        "HOME": str(work),
        "PYTHONUNBUFFERED": "1",
        "PATH": f"{bin_folder}{os.pathsep}{os.environ['PATH']}",
        "LC_ALL": "C.UTF-8",
    }
    wrong = []
    for trial in TRIALS:
        missing = set(trial.needs) - set(extra.split(","))
        if (extra and not trial.needs) or not (trial.tells if missing else trial.runs):
            continue
        run = _served if trial.serves else _run
        done = run(shlex.split(trial.line), work, environment)
        problem = _problem(missing, done)
        if problem:
            wrong.append(f"{given.python} [{extra}] {trial.line}: {problem}")
    return wrong


def _run(
    command: Sequence[str], work: Path, environment: Mapping[str, str]
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command, check=False, capture_output=True, text=True, cwd=work, env=environment, timeout=600
    )


def _served(
    command: Sequence[str], work: Path, environment: Mapping[str, str]
) -> subprocess.CompletedProcess[str]:
    """The same of a server, which is ended when it listens; its status is 0 then."""
    with (
        tempfile.TemporaryFile("w+") as errors,
        subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=errors, text=True, cwd=work, env=environment
        ) as server,
    ):
        assert server.stdout is not None
        is_listening = any("Ctrl-C" in line for line in server.stdout)
        server.terminate()
        status = server.wait(60)
        errors.seek(0)
        said = errors.read()
        return subprocess.CompletedProcess(command, 0 if is_listening else status, "", said)


def _problem(missing: set[str], done: subprocess.CompletedProcess[str]) -> str:
    said = done.stderr.strip()
    if not missing:
        return "" if done.returncode == 0 else f"status {done.returncode}: {said}"
    told = said + done.stdout
    named = any(f"corpus-tools-g3[{extra}]" in told for extra in missing)
    if done.returncode != 2 or not named or len(said.splitlines()) > 1:
        return f"status {done.returncode} without {missing}: {told[-600:]!r}"
    return ""


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
