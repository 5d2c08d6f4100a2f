"""Working on many items: here, in processes that may die, and on a real Dask cluster."""

from __future__ import annotations

import math
import multiprocessing
import os
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.labelled_corpus import Options
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.parallel import Executor, WorkerDiedError, Workers, work
from corpus_tools.shards.shard_making import write_shards
from corpus_tools.shards.shard_training import fit_on_shards
from eval.statistics.estimates import resampled_sums
from eval.table_3.end_to_end import run as run_table_3
from g3.errors import CorpusError
from g3.learning.grounding_model import GroundingModel
from tests.corpus_tools.runtime.parallel_work import die, die_once, square
from tests.tiny_corpus import tiny_corpus


def results(done):
    return sorted((d.item, d.result, type(d.error)) for d in done)


def program(name):
    return [sys.executable, "-m", f"distributed.cli.dask_{name}"]


@contextmanager
def scheduler():
    """The address of a scheduler in a process of its own."""
    pytest.importorskip("distributed")
    process = subprocess.Popen(
        [*program("scheduler"), "--host", "127.0.0.1", "--port", "0", "--no-dashboard"],
        # What two processes died of isn't begun a third time.
        env={**os.environ, "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1"},
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
    )
    try:
        lines = iter(process.stderr.readline, "")
        yield next(line.split()[-1] for line in lines if "Scheduler at" in line)
    finally:
        process.terminate()
        process.wait()
        process.stderr.close()


@contextmanager
def worker(address):
    """Keep a worker running, as systemd does.

    Dask's own nanny gives up when its worker dies before it has seen it start.
    """
    begun = []
    ended = threading.Event()

    def keep_running():
        while not ended.is_set():
            process = subprocess.Popen(
                [*program("worker"), address, "--no-nanny", "--nthreads", "1", "--no-dashboard"],
                env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])},
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            begun.append(process)
            process.wait()

    thread = threading.Thread(target=keep_running)
    thread.start()
    yield
    ended.set()
    while thread.is_alive():
        for process in begun:
            process.terminate()
        thread.join(0.5)


@pytest.fixture(scope="module")
def cluster():
    """The address of a scheduler with two workers, each in a process of its own."""
    with scheduler() as address, worker(address), worker(address):
        yield address


def test_all_ways_give_the_same():
    expected = [(x, None if x == 13 else x * x) for x in range(20)]
    for workers in (Workers(), Workers(jobs=3)):
        done = list(work(square, range(20), workers))
        assert sorted((d.item, d.result) for d in done) == expected
        assert [str(d.error) for d in done if d.error is not None] == ["unlucky"]


def test_a_process_that_dies_is_replaced(tmp_path):
    done = list(work(partial(die_once, folder=tmp_path), range(4), Workers(jobs=2)))
    assert results(done) == [(x, x, type(None)) for x in range(4)]


def test_an_item_that_always_kills_costs_only_itself():
    done = list(work(die, range(4), Workers(jobs=2)))
    assert results([d for d in done if d.item != 2]) == [(x, x, type(None)) for x in (0, 1, 3)]
    (bad,) = (d for d in done if d.item == 2)
    assert isinstance(bad.error, WorkerDiedError)


def test_who_stops_listening_leaves_no_process():
    running = work(time.sleep, [0.01] + [60.0] * 5, Workers(jobs=2))
    next(running)
    running.close()
    end = time.monotonic() + 20
    while multiprocessing.active_children() and time.monotonic() < end:
        time.sleep(0.05)
    assert multiprocessing.active_children() == []


@pytest.mark.slow
def test_a_cluster_of_two_workers(cluster):
    done = list(work(math.sqrt, [float(x) for x in range(-1, 30)], Workers(scheduler=cluster)))
    assert sorted(d.result for d in done if d.error is None) == [math.sqrt(x) for x in range(30)]
    (bad,) = (d for d in done if d.error is not None)
    assert isinstance(bad.error, ValueError)


@pytest.mark.slow
def test_workers_of_a_cluster_that_die(cluster, tmp_path):
    function = partial(die_once, folder=tmp_path)
    done = list(work(function, range(3), Workers(scheduler=cluster)))
    assert results(done) == [(x, x, type(None)) for x in range(3)]

    done = {d.item: d for d in work(die, range(1, 4), Workers(scheduler=cluster))}
    assert isinstance(done[2].error, WorkerDiedError)
    assert (done[1].result, done[3].result) == (1, 3)


@pytest.mark.slow
def test_rendering_on_a_cluster(cluster, tmp_path, capsys):
    command = ["render-videos", "dock_put_down_boxes", "--fps", "1"]
    small = ["--size", "64x64", "--quality", "draft"]
    assert run([*command, *small, "--out", str(tmp_path / "here")]) == 0
    assert run([*command, *small, "--out", str(tmp_path / "there"), "--scheduler", cluster]) == 0
    assert capsys.readouterr().out == "rendered 1\n" * 2
    made = sorted(p.relative_to(tmp_path / "here") for p in (tmp_path / "here").glob("*/*.*"))
    assert made
    for file in made:
        assert (tmp_path / "here" / file).read_bytes() == (tmp_path / "there" / file).read_bytes()


@pytest.mark.slow
def test_training_on_a_cluster(cluster, tmp_path):
    tiny_corpus().save(tmp_path / "tiny")
    made = []
    for name, workers in (("here", Workers()), ("there", Workers(scheduler=cluster))):
        options = Options(ablated=("word-wordnet",))
        manifest, failures = write_shards(
            [str(tmp_path / "tiny")], tmp_path / name, options, workers=workers, size=20
        )
        assert not failures
        folder = tmp_path / name
        model = fit_on_shards(GroundingModel(), folder, manifest, workers=workers, tolerance=2.0)
        made.append((manifest, model.weights_.tobytes()))
    assert made[0] == made[1]


@pytest.mark.slow
def test_the_resamples_of_a_bootstrap_on_a_cluster(cluster):
    counts = np.arange(30).reshape(10, 3)
    with Executor(Workers(scheduler=cluster)) as executor:
        there = resampled_sums(counts, rng=np.random.default_rng(3), draws=600, executor=executor)
    here = resampled_sums(counts, rng=np.random.default_rng(3), draws=600)
    np.testing.assert_array_equal(there, here)


@pytest.mark.slow
def test_table_3_on_a_cluster(cluster, tmp_path):
    """Each of two scenarios is followed with what was learned from the other."""
    whole = open_corpus("warehouse")
    ids = ("court_put_crate_on_trailer-01", "hall_pick_up_boxes-01")
    annotations = [a for a in whole.annotations if a.command.id in ids]
    few = Corpus.build(
        "few",
        contexts=list({a.context.id: a.context for a in annotations}.values()),
        commands=[whole.commands[command] for command in ids],
        annotations=annotations,
        judgments=[],
        source=whole.source,
        licence=whole.licence,
    )
    few.save(tmp_path / "few")
    name = str(tmp_path / "few")
    there = run_table_3(
        name, name, configurations=("gold",), workers=Workers(scheduler=cluster)
    ).outcomes
    assert there == run_table_3(name, name, configurations=("gold",)).outcomes
    assert len(there["gold"]) == len(ids)


@pytest.mark.slow
def test_a_cluster_without_workers(monkeypatch):
    monkeypatch.setattr("corpus_tools.runtime.parallel.LOOK_S", 0.1)
    monkeypatch.setattr("corpus_tools.runtime.parallel.WITHOUT_WORKERS_S", 0.3)
    with (
        scheduler() as address,
        pytest.raises(CorpusError, match="no workers for a while") as e,
    ):
        list(work(square, [1, 2], Workers(scheduler=address)))
    assert address in str(e.value)


def test_no_scheduler(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("corpus_tools.runtime.parallel.CONNECT_S", 0.3)
    with pytest.raises(CorpusError, match="no Dask scheduler"):
        list(work(square, [1], Workers(scheduler="tcp://127.0.0.1:1")))
