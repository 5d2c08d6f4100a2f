"""Making the files of one item: video, poster, segmentation, log and manifest."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

import cv2
import msgspec
import numpy as np
import numpy.typing as npt

from corpus_tools import __version__
from corpus_tools.logs.log_writing import to_bytes
from corpus_tools.runtime.atomic_folder import write_folder
from corpus_tools.video.drawing.canvas import Image
from corpus_tools.video.drawing.segmentation import describe, label_image
from corpus_tools.video.films import Film, film
from corpus_tools.video.items import Item, story_of
from corpus_tools.video.manifest import MANIFEST, Settings, input_hash, is_finished, manifest
from g3.errors import CorpusError
from g3.storage.system_errors import about

VIDEO, POSTER, LOG = "video.mp4", "poster.png", "log.mcap"
SEGMENTATION, SEGMENTS = "segmentation.png", "segmentation.json"

OnFrameCount = Callable[[int, int], None]
"""Called with how many frames are done, and how many there are."""


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
