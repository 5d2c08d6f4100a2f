"""Episodes of robomimic's HDF5 files, with what MimicGen, RoboCasa and LIBERO add.

``data/demo_N/obs/CAMERA`` holds the pictures of an episode, shape (frames, height, width, 3). Its
task is in the attribute ``ep_meta`` of the episode (RoboCasa, ``lang``) or in ``problem_info`` of
``data`` (LIBERO, ``language_instruction``), both JSON.

A file may name other files as the place of its content. Such links are refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from corpus_tools.episodes.curves import EpisodeCurves, drawable, named_curves
from corpus_tools.episodes.films import RESTORE, Picture
from corpus_tools.episodes.study_tables import OnError, RecordedEpisode
from corpus_tools.runtime.extras import import_extra
from corpus_tools.tables.curve_file import Values
from corpus_tools.video.picture_file import MOST_PIXELS
from g3.errors import CorpusError, FormatError

ENDINGS = (".hdf5", ".h5")
FPS = 20.0
"""Frames a second where the file gives none: robosuite's default control frequency."""
FASTEST = 1000.0
MOST_CHUNK = 256 << 20
"""Bytes of a part that is uncompressed at once."""
ROWS_AT_ONCE = 1 << 12
_DEPTH = re.compile(r"depth")
_FIX_FILE = "name an HDF5 file, or a folder of them"
_FIX_CAMERAS = (
    "write the pictures into the file with robomimic's dataset_states_to_obs.py and its option "
    "--camera_names"
)


@dataclass(frozen=True, slots=True)
class Demonstrations:
    """The episodes of a file, or of all files in a folder.

    Parameters
    ----------
    path
        The given file or folder, resolved.
    files
        The files, in the order of their names.
    """

    path: Path
    files: tuple[Path, ...]
    cameras: tuple[str, ...]
    depth_cameras: frozenset[str]
    other_cameras: frozenset[str]
    fps: float | None
    """Frames a second instead of those of the files."""
    without_cameras: str = _FIX_CAMERAS
    notes: tuple[str, ...] = ()

    def episodes(self, cameras: Sequence[str], on_error: OnError) -> Iterator[RecordedEpisode]:
        """Yield the episodes in the order of files and of the numbers in their names."""
        for index, file, data, name in demonstrations(self.files, on_error):
            try:
                yield self._episode(data, name, file, index, cameras)
            except CorpusError as error:
                on_error(error)

    def _episode(
        self, data: Any, name: str, file: Path, index: int, cameras: Sequence[str]
    ) -> RecordedEpisode:
        place = f"{file}, data/{name}"
        demo = child(data, name, place)
        obs = child(demo, "obs", place)
        # MuJoCo draws from the bottom up; robosuite says so where it didn't turn pictures over.
        is_upside_down = _text(data.attrs.get("macros_image_convention")) == "opengl"
        views = {
            camera: _pictures(obs, camera, f"{place}/obs", is_upside_down=is_upside_down)
            for camera in cameras
        }
        rate = self.fps or _rate(data, file)
        curves = partial(_curves, demo, place, rate)
        return RecordedEpisode(
            index, f"{file.name}/{name}", tasks_of(data, demo, place), rate, views, curves=curves
        )


def demonstrations(
    files: Sequence[Path], on_error: OnError, *, is_written: bool = False
) -> Iterator[tuple[int, Path, Any, str]]:
    """Yield the number of each episode, its file, the group of episodes, and its name there.

    The files may be changed if they are opened so.
    """
    index = 0
    for file in files:
        try:
            with _opened(file, is_written=is_written) as hdf5:
                data = child(hdf5, "data", file)
                for name in _names(data):
                    yield index, file, data, name
                    index += 1
        except CorpusError as error:
            on_error(error)


def open_demonstrations(path: Path, *, fps: float | None = None) -> Demonstrations:
    """Open a file, or all files of a folder.

    Parameters
    ----------
    fps
        Frames a second instead of those of the files.
    """
    path = path.resolve()
    files = (
        tuple(sorted(f for f in path.rglob("*") if f.suffix in ENDINGS and f.is_file()))
        if path.is_dir()
        else (path,)
    )
    if not files:
        fix = f"name a file, or a folder of files that end in {' or '.join(ENDINGS)}"
        raise FormatError("there are no HDF5 files", where=str(path), fix=fix)
    with _opened(files[0]) as hdf5:
        data = child(hdf5, "data", files[0])
        names = _names(data)
        if not names:
            raise FormatError("there are no episodes", where=f"{files[0]}, data", fix=RESTORE)
        place = f"{files[0]}, data/{names[0]}"
        demo = child(data, names[0], place)
        cameras = dict(_cameras(demo, place)) if "obs" in demo else {}
    depth = frozenset(name for name in cameras if _DEPTH.search(name))
    others = frozenset(name for name, kind in cameras.items() if kind != np.uint8)
    return Demonstrations(path, files, tuple(cameras), depth, others, fps)


@contextmanager
def _opened(file: Path, *, is_written: bool = False) -> Iterator[Any]:
    """Open a file; a FormatError names it, if it can't be read or is damaged."""
    h5py = import_extra("h5py", "hdf5", "HDF5 files are read")
    if not file.is_file():
        what = "this is no file" if file.exists() else "there is no such file"
        raise FormatError(what, where=str(file), fix=_FIX_FILE)
    if not h5py.is_hdf5(file):
        what = "the file can't be read as HDF5: it doesn't begin as such a file does"
        raise FormatError(what, where=str(file), fix=_FIX_FILE)
    mode = "r+" if is_written else "r"
    with content_of(str(file)), h5py.File(file, mode, locking=False) as hdf5:
        yield hdf5


@contextmanager
def content_of(where: str) -> Iterator[None]:
    """Turn any error that damaged content causes into a FormatError."""
    try:
        yield
    except CorpusError:
        raise
    except (OSError, ValueError, TypeError, LookupError, RuntimeError, MemoryError) as error:
        lines = str(error).splitlines() or [type(error).__name__]
        what = f"the file can't be read as HDF5: {lines[0]}"
        raise FormatError(what, where=where, fix=RESTORE) from error


def child(group: Any, name: str, where: object) -> Any:
    """Return a member of a group that lies in the same file."""
    h5py = import_extra("h5py", "hdf5", "HDF5 files are read")
    with content_of(str(where)):
        link = group.get(name, getlink=True) if isinstance(group, h5py.Group) else None
        if link is None:
            raise FormatError(
                f"there is no {name}",
                where=str(where),
                fix="give a file that robomimic, MimicGen, RoboCasa or LIBERO has written",
            )
        if not isinstance(link, h5py.HardLink):
            raise FormatError(
                f"{name} is a link to another place",
                where=str(where),
                fix="copy the content into the file itself",
            )
        member = group[name]
        if isinstance(member, h5py.Dataset) and (member.external or member.is_virtual):
            raise FormatError(
                f"the content of {name} is in another file",
                where=str(where),
                fix="copy the content into the file itself",
            )
        return member


def _names(data: Any) -> list[str]:
    """Return the names of episodes in the order of their numbers."""
    return sorted(data, key=lambda name: [int(d) for d in re.findall(r"\d{1,18}", name)] or [0])


def _cameras(demo: Any, where: str) -> Iterator[tuple[str, Any]]:
    obs = child(demo, "obs", where)
    for name in obs:
        member = child(obs, name, f"{where}/obs")
        if len(getattr(member, "shape", ())) == 4 and member.shape[-1] in (1, 3):
            yield name, member.dtype


def _check_pictures(pictures: Any, where: str) -> None:
    shape: tuple[int, ...] = getattr(pictures, "shape", ())
    kind: Any = getattr(pictures, "dtype", None)
    if len(shape) != 4 or shape[-1] not in (1, 3) or min(shape[1:3]) < 2:
        what = f"the shape {shape} isn't that of pictures: (frames, height, width, 3)"
        raise FormatError(what, where=where, fix=RESTORE)
    if kind != np.uint8 and not _DEPTH.search(where.rpartition("/")[2]):
        what = f"the pictures are of the type {kind}, and only uint8 is read"
        raise FormatError(what, where=where, fix="convert them to numbers from 0 to 255")
    chunk = int(np.prod(pictures.chunks or (1, *shape[1:]), dtype=float)) * kind.itemsize
    if shape[1] * shape[2] > MOST_PIXELS or chunk > MOST_CHUNK:
        raise FormatError("the pictures are too large", where=where, fix="make them smaller")


def _pictures(obs: Any, camera: str, of: str, *, is_upside_down: bool) -> Iterator[Picture]:
    where = f"{of}/{camera}"
    pictures = child(obs, camera, of)
    _check_pictures(pictures, where)
    for number in range(len(pictures)):
        place = f"{where}, frame {number}"
        with content_of(place):
            pixels = pictures[number]
        if pixels.dtype != np.uint8:  # distances
            pixels = _as_grey(pixels)
        if pixels.shape[-1] == 1:
            pixels = np.repeat(pixels, 3, axis=-1)
        if is_upside_down:
            pixels = pixels[::-1]
        yield Picture(np.ascontiguousarray(pixels), place)


def _curves(demo: Any, where: str, rate: float, frames: int) -> EpisodeCurves | None:
    """Return the actions, and the observations that are numbers; each row is a frame."""
    members = {}
    for name in ("actions", *(f"obs/{name}" for name in demo["obs"])):
        group, _, last = name.rpartition("/")
        parent = demo[group] if group else demo
        if last in parent:
            members[name] = child(parent, last, f"{where}/{group}")
    widths = drawable(
        (name, member.shape[1] if member.ndim == 2 else 1)
        for name, member in members.items()
        if getattr(member, "dtype", np.dtype("O")).kind in "fiu"
        and member.ndim in (1, 2)
        and len(member) == frames
        and _chunk_bytes(member) <= MOST_CHUNK
    )
    if not widths:
        return None
    curves = [curve for name, width in widths.items() for curve in named_curves(name, width)]
    drawn = {name: members[name] for name in widths}
    return EpisodeCurves(curves, rate, frames, _rows(drawn, frames, where))


def _rows(members: Mapping[str, Any], frames: int, where: str) -> Iterator[Values]:
    for first in range(0, frames, ROWS_AT_ONCE):
        columns = []
        for name, member in members.items():
            with content_of(f"{where}/{name}"), np.errstate(over="ignore"):
                part = member[first : first + ROWS_AT_ONCE].astype(np.float32)
            columns.append(part.reshape(len(part), -1))
        yield np.concatenate(columns, axis=1)


def _chunk_bytes(member: Any) -> float:
    """Return the number of bytes that are uncompressed at once."""
    rows: tuple[int, ...] = member.chunks or (ROWS_AT_ONCE, *member.shape[1:])
    return float(np.prod(rows, dtype=float)) * float(member.dtype.itemsize)


def _as_grey(distances: Any) -> Any:
    """Return distances as shades, the nearest of a picture white."""
    values = np.nan_to_num(distances.astype(np.float64))
    span = float(np.ptp(values)) or 1.0
    return np.round(255 * (values.max() - values) / span).astype(np.uint8)


def _rate(data: Any, file: Path) -> float:
    """Return the environment's control frequency, hertz."""
    arguments = json_of(data, "env_args", f"{file}, data")
    options = arguments.get("env_kwargs")
    rate = options.get("control_freq") if isinstance(options, Mapping) else None
    if rate is None:
        return FPS
    is_number = isinstance(rate, int | float) and not isinstance(rate, bool)
    if not is_number or not 0 < rate <= FASTEST:
        what = f"control_freq is {rate!r:.40}"
        raise FormatError(what, where=f"{file}, data, env_args", fix="give --fps")
    return float(rate)


def tasks_of(data: Any, demo: Any, where: str) -> tuple[str, ...]:
    """Return the task of an episode, else that of its file."""
    texts = json_of(demo, "ep_meta", where).get("lang")
    if not texts:
        texts = json_of(data, "problem_info", where).get("language_instruction")
    listed = texts if isinstance(texts, list) else [texts]
    # LIBERO has texts in quotation marks, as in its task files.
    cleaned = (text.strip().strip('"').strip() for text in listed if isinstance(text, str))
    return tuple(dict.fromkeys(text for text in cleaned if text))


def json_of(group: Any, name: str, where: str) -> Mapping[str, Any]:
    """Return the JSON of an attribute; nothing if there is no such attribute."""
    place = f"{where}, attribute {name}"
    with content_of(place):
        text = _text(group.attrs.get(name))
    try:
        return msgspec.json.decode(text, type=dict[str, Any]) if text else {}
    except (msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise FormatError(f"this is no JSON object: {error}", where=place, fix=RESTORE) from error


def _text(value: Any) -> str:
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value if isinstance(value, str) else ""
