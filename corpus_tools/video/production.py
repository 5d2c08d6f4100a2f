"""Files of items, of one or of many: video, poster, segmentation, log and manifest."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from corpus_tools import __version__
from corpus_tools.logs.log_writing import to_bytes
from corpus_tools.runtime.atomic_folder import write_folder
from corpus_tools.runtime.parallel import Done, WorkerDiedError, Workers, work
from corpus_tools.video.drawing.canvas import Image
from corpus_tools.video.drawing.gl import VARIABLE, choose_back_end
from corpus_tools.video.drawing.segmentation import describe, label_image
from corpus_tools.video.films import Film, film
from corpus_tools.video.items import Item, story_of
from corpus_tools.video.manifest import MANIFEST, Settings, input_hash, is_finished, manifest
from g3.errors import CorpusError
from g3.storage.system_errors import about, named_error

VIDEO, POSTER, LOG = "video.mp4", "poster.png", "log.mcap"
SEGMENTATION, SEGMENTS = "segmentation.png", "segmentation.json"

OnFrameCount = Callable[[int, int], None]
"""Called with how many frames are done, and how many there are."""

THREADS = "LP_NUM_THREADS"
"""Number of threads that Mesa starts in a process; it would start them for all cores in each."""


def produce(
    item: Item, out: Path, settings: Settings, *, force: bool, on_frame: OnFrameCount | None = None
) -> bool:
    """Make an item's folder, unless it is finished.

    The folder gets its name when all is in it and on the disk.

    Parameters
    ----------
    out
        The folder of that folder.
    force
        True to make it again if it is finished.

    Returns
    -------
    bool
        True if it was made; else it was finished.

    Raises
    ------
    CorpusError
        If the item can't be read or doesn't work out, or the folder holds other things.
    """
    story = story_of(item)
    folder = out / item.name
    if not force and is_finished(folder, input_hash(story, settings)):
        return False
    # What a killed run has left.
    for left in out.glob(f".{item.name}.*"):
        shutil.rmtree(left, ignore_errors=True)
    recording = story.record()
    metadata = {"program": __version__, **story.metadata}
    files = {LOG: to_bytes(recording, name=story.id, metadata=metadata)}
    posters: list[Image] = []

    def note(made: Film, k: int, picture: Image) -> None:
        if k == made.poster:
            posters.append(picture)
        if on_frame is not None:
            on_frame(k + 1, len(made.recording.t_ns))

    with (
        about(folder),
        tempfile.TemporaryDirectory(dir=out, prefix=f".{item.name}.") as scratch,
        about(folder, instead_of=scratch),
    ):
        video = Path(scratch) / VIDEO
        made = film(recording, video, settings, site=story.site, on_frame=note)
        files[VIDEO] = video.read_bytes()
    files[POSTER] = _png(posters[0][..., ::-1])
    files[SEGMENTATION] = _png(label_image(made.objects))
    segments = describe(made.objects, recording.start, made.cameras[0])
    files[SEGMENTS] = msgspec.json.encode(segments) + b"\n"
    files[MANIFEST] = manifest(story, settings, made.recording, made.cameras, files)
    write_folder(folder, files, force=True, marker=MANIFEST)
    return True


def _png(picture: npt.NDArray[np.uint8] | npt.NDArray[np.uint16]) -> bytes:
    done, content = cv2.imencode(".png", picture)
    if not done:
        raise CorpusError("a picture can't be written as PNG")
    return content.tobytes()


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of rendering an item."""

    name: str
    made: bool
    """True if its files were made; else they were there, or it failed."""
    problem: str = ""
    """Reason why it failed; empty if it didn't."""
    is_bug: bool = False
    """True if the input is not to blame."""


def produce_all(
    items: Iterable[Item],
    out: Path,
    settings: Settings,
    *,
    workers: Workers,
    force: bool,
    on_frame: Callable[[str], OnFrameCount] | None = None,
) -> Iterator[Outcome]:
    """Make all items' folders; one that fails doesn't stop the others.

    Each process of the workers makes the same files as this one would. `on_frame` gives for an
    item's name what to call with its frames; only with one job.
    """
    if workers == Workers():
        for item in items:
            frame_count = on_frame(item.name) if on_frame else None
            yield _outcome(item, out=out, settings=settings, force=force, on_frame=frame_count)
        return
    make = partial(_outcome_elsewhere, out=out.absolute(), settings=settings, force=force)
    yield from map(_outcome_of, work(make, items, workers))


def _outcome_elsewhere(item: Item, *, out: Path, settings: Settings, force: bool) -> Outcome:
    os.environ.setdefault(THREADS, "1")
    if VARIABLE not in os.environ:
        choose_back_end()
    return _outcome(item, out=out, settings=settings, force=force)


def _outcome(
    item: Item, *, out: Path, settings: Settings, force: bool, on_frame: OnFrameCount | None = None
) -> Outcome:
    try:
        return Outcome(item.name, produce(item, out, settings, force=force, on_frame=on_frame))
    except CorpusError as error:
        return Outcome(item.name, made=False, problem=str(error))
    except Exception as error:
        named = named_error(error) if isinstance(error, OSError) else None
        if named is not None:
            return Outcome(item.name, made=False, problem=str(named))
        problem = f"unexpected error: {type(error).__name__}: {error}"
        return Outcome(item.name, made=False, problem=problem, is_bug=True)


def _outcome_of(done: Done[Item, Outcome]) -> Outcome:
    if done.result is not None:
        return done.result
    again = " (run again)" if isinstance(done.error, WorkerDiedError) else ""
    return Outcome(done.item.name, made=False, problem=f"{done.error}{again}", is_bug=True)
