"""A corpus as a LeRobot dataset (version 3 or 2.1): an episode for each context with a log.

The robot's pose is the state, its pose at the next frame the action. The first annotated command
is the episode's task, and its EVENT clauses are subtasks from when on they are done. Other
people's commands for the same log are other wordings of the task (``task_aug``).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np
import numpy.typing as npt

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.lerobot import language_rows
from corpus_tools.lerobot.episode_reading import EPISODES_JSONL, INFO, NEW, OLD, PATHS
from corpus_tools.lerobot.language_rows import LANGUAGE_JSONL, SUBTASK, Language
from corpus_tools.lerobot.task_tables import TASKS_JSONL, TASKS_PARQUET, tasks_parquet
from corpus_tools.runtime.parquet import import_pyarrow, parquet_bytes
from corpus_tools.video.cutting import first_picture, whole
from corpus_tools.video.probe import probe
from g3.annotation import Annotation, Command
from g3.errors import FormatError
from g3.groundings import Context, Place, Trajectory
from g3.sdc.clauses import all_words, breadth_first
from g3.storage import regular_file

FPS = 10
"""Frames a second of episodes without a video."""
NAMES = ("x", "y", "z", "yaw")
IMAGES = "observation.images"
"""The beginning of a camera's key; its end is the camera of ``ct render-videos``."""
DATA = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
VIDEOS = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
FILES_IN_CHUNK = 1000
_RENDER = "render it again: ct render-videos --corpus CORPUS --out FOLDER --force"
QUANTILES = (0.01, 0.10, 0.50, 0.90, 0.99)

Array = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class _Film:
    """A rendered video: its file, camera, frames, frames a second, height and width."""

    file: Path
    camera: str
    frames: int
    fps: int
    size: tuple[int, int]


@dataclass(frozen=True, slots=True)
class _Recorded:
    """An episode to be written; the state has shape (n, 4)."""

    context: Context
    task: str
    state: Array
    timestamps: Array
    language: list[dict[str, Any]]
    films: tuple[_Film, ...]


def lerobot_files(corpus: Corpus, videos: Sequence[Path]) -> dict[str, bytes | Path]:
    """Return the dataset's files. Videos are taken as they are.

    `videos` are folders that ``ct render-videos --corpus`` has made, one for each camera: contexts
    without a video are left out. There are none for a dataset without videos. Raises FormatError if
    nothing moves in the corpus, a video is missing, or pyarrow isn't installed.
    """
    films = _by_context(videos)
    recorded = _recorded(corpus, films, has_videos=bool(videos))
    fps = next((film.fps for r in recorded for film in r.films), FPS)
    tasks = list(dict.fromkeys(r.task for r in recorded))
    files: dict[str, bytes | Path] = {
        DATA.format(chunk_index=0, file_index=0): _frames(recorded, tasks),
        TASKS_PARQUET: tasks_parquet(tasks),
        "meta/episodes/chunk-000/file-000.parquet": _episodes(recorded),
        "meta/stats.json": _json(_statistics(recorded)),
        INFO: _json(_info(corpus, recorded, tasks, fps)),
        "README.md": _card(corpus).encode(),
    }
    for number, item in enumerate(recorded):
        chunk, place = divmod(number, FILES_IN_CHUNK)
        for film in item.films:
            name = VIDEOS.format(video_key=film.camera, chunk_index=chunk, file_index=place)
            files[name] = film.file
    return files


def lerobot_2_files(corpus: Corpus, videos: Sequence[Path]) -> dict[str, bytes | Path]:
    """Return the files of a dataset of version 2.1, with a file for each episode.

    That version has no columns for language, and its readers refuse columns that they don't know:
    what an episode has beside its task is in ``meta/language.jsonl``. The parameters and errors
    are those of :func:`lerobot_files`.
    """
    recorded = _recorded(corpus, _by_context(videos), has_videos=bool(videos))
    tasks = list(dict.fromkeys(item.task for item in recorded))
    fps = next((film.fps for item in recorded for film in item.films), FPS)
    data, of_video = PATHS[True]
    files: dict[str, bytes | Path] = {}
    for number, table in enumerate(_tables(recorded, tasks)):
        names = {"episode_chunk": number // FILES_IN_CHUNK, "episode_index": number}
        files[data.format(**names)] = parquet_bytes(table)
        for film in recorded[number].films:
            files[of_video.format(**names, video_key=film.camera)] = film.file
    info = _info(corpus, recorded, tasks, fps)
    for name in (language_rows.PERSISTENT, language_rows.EVENTS):
        del info["features"][name]
    of_version = {
        "codebase_version": OLD,
        "total_chunks": -(-len(recorded) // FILES_IN_CHUNK),
        "total_videos": sum(len(item.films) for item in recorded),
        "data_path": data,
        "video_path": of_video if info["video_path"] else None,
    }
    of_episodes = [
        {"episode_index": n, "tasks": [item.task], "length": len(item.timestamps)}
        for n, item in enumerate(recorded)
    ]
    return files | {
        INFO: _json(info | of_version),
        EPISODES_JSONL: _lines(of_episodes),
        TASKS_JSONL: _lines({"task_index": n, "task": task} for n, task in enumerate(tasks)),
        "meta/episodes_stats.jsonl": _lines(
            {"episode_index": n, "stats": _statistics([item])} for n, item in enumerate(recorded)
        ),
        LANGUAGE_JSONL: _lines(
            {"episode_index": n, **row} for n, item in enumerate(recorded) for row in item.language
        ),
        "README.md": _card(corpus, f"`{LANGUAGE_JSONL}`").encode(),
    }


def _recorded(
    corpus: Corpus, films: Mapping[str, tuple[_Film, ...]], *, has_videos: bool
) -> list[_Recorded]:
    said, annotated = _commands_of(corpus)
    found = []
    for context in corpus.contexts.values():
        if len(context.agent.trajectory) < 2 or not said[context.id]:
            continue
        shown = films.get(context.id, ())
        if has_videos and not shown:
            continue
        for film in shown:
            _check(film)
        fps = shown[0].fps if shown else FPS
        path = context.agent.trajectory
        frames = shown[0].frames if shown else int((path.t[-1] - path.t[0]) * fps) + 1
        timestamps = (np.arange(frames) / fps).astype(np.float32)
        times = np.arange(frames) / fps
        task, language = _language(said[context.id], annotated[context.id], float(path.t[0]))
        items = language_rows.placed(language, times, 1 / fps)
        items += language_rows.plans(item for item in items if item.language.style == SUBTASK)
        rows = language_rows.rows_of(items, timestamps, tasks=[task])
        state = _state(path, path.t[0] + times)
        found.append(_Recorded(context, task, state, timestamps, rows, shown))
    if not found:
        what = "there is no video of a log in the corpus" if has_videos else "nothing moves in it"
        raise FormatError(
            what, where=corpus.name, fix="export a corpus with logs, such as warehouse"
        )
    return found


def _commands_of(
    corpus: Corpus,
) -> tuple[Mapping[str, list[Command]], Mapping[str, list[Annotation]]]:
    """Return the commands and the positive annotations of each context, by its id."""
    annotated: dict[str, list[Annotation]] = defaultdict(list)
    scenarios: dict[str, str] = {name: name for name in corpus.contexts}
    for annotation in corpus.annotations:
        scenarios[annotation.command.scenario] = annotation.context.id
        if annotation.source == "positive":
            annotated[annotation.context.id].append(annotation)
    said: dict[str, list[Command]] = defaultdict(list)
    for command in corpus.commands.values():
        if command.scenario in scenarios:
            said[scenarios[command.scenario]].append(command)
    return said, annotated


def _language(
    said: Sequence[Command], annotated: Sequence[Annotation], begin_s: float
) -> tuple[str, list[language_rows.Language]]:
    """Return the task, and its other wordings and subtasks."""
    task = annotated[0].command if annotated else said[0]
    wordings = [Language(language_rows.TASK_AUG, 0.0, command.text) for command in said]
    return task.text, [*wordings, *(_subtasks(annotated[0], begin_s) if annotated else [])]


def _subtasks(annotation: Annotation, begin_s: float) -> list[Language]:
    """Return the subtasks of a command: its EVENT clauses, by their beginnings.

    Clauses with one beginning have no times of their own. They are one subtask, with the words
    from the first to the last of them.
    """
    words_from: dict[float, list[tuple[int, int]]] = defaultdict(list)
    nodes = zip(
        breadth_first(annotation.sdcs), annotation.groundings, annotation.correct, strict=True
    )
    for sdc, groundings, correct in nodes:
        paths = [g.trajectory for g in groundings if not isinstance(g, Place)]
        words = all_words(sdc)
        if sdc.type == "EVENT" and words and paths and correct is not False:
            start_s = max(float(paths[0].t[0]) - begin_s, 0.0)
            words_from[start_s].append((words[0].start, words[-1].end))
    text = annotation.command.text
    return [
        Language(SUBTASK, start_s, text[min(s for s, _ in spans) : max(e for _, e in spans)])
        for start_s, spans in words_from.items()
    ]


def _state(path: Trajectory, times: npt.NDArray[np.float64]) -> Array:
    """Poses at times, shape (n, 4)."""
    columns = [*path.xyz.T, np.unwrap(path.yaw)]
    return np.column_stack([np.interp(times, path.t, c) for c in columns]).astype(np.float32)


def _frames(recorded: Sequence[_Recorded], tasks: Sequence[str]) -> bytes:
    pa, _ = import_pyarrow()
    types = language_rows.column_types()
    tables = []
    for table, item in zip(_tables(recorded, tasks), recorded, strict=True):
        n = len(item.timestamps)
        columns = {language_rows.PERSISTENT: [item.language] * n, language_rows.EVENTS: [[]] * n}
        for name, values in columns.items():
            table = table.append_column(name, pa.array(values, types[name]))  # noqa: PLW2901
        tables.append(table)
    return parquet_bytes(pa.concat_tables(tables))


def _tables(recorded: Sequence[_Recorded], tasks: Sequence[str]) -> Iterator[Any]:
    """Yield the frames of each episode as a table, without its language."""
    pa, _ = import_pyarrow()
    vector, whole = pa.list_(pa.float32(), len(NAMES)), pa.int64()
    index = 0
    for number, item in enumerate(recorded):
        n = len(item.timestamps)
        action = np.vstack([item.state[1:], item.state[-1:]])
        columns = {
            "observation.state": pa.array(item.state.tolist(), vector),
            "action": pa.array(action.tolist(), vector),
            "timestamp": pa.array(item.timestamps),
            "frame_index": pa.array(range(n), whole),
            "episode_index": pa.array([number] * n, whole),
            "index": pa.array(range(index, index + n), whole),
            "task_index": pa.array([tasks.index(item.task)] * n, whole),
        }
        yield pa.table(columns)
        index += n


def _episodes(recorded: Sequence[_Recorded]) -> bytes:
    pa, _ = import_pyarrow()
    rows, first = [], 0
    for number, item in enumerate(recorded):
        n = len(item.timestamps)
        row: dict[str, Any] = {
            "episode_index": number,
            "tasks": [item.task],
            "length": n,
            "data/chunk_index": 0,
            "data/file_index": 0,
            "dataset_from_index": first,
            "dataset_to_index": first + n,
        }
        chunk, place = divmod(number, FILES_IN_CHUNK)
        for film in item.films:
            row |= {
                f"videos/{film.camera}/chunk_index": chunk,
                f"videos/{film.camera}/file_index": place,
                f"videos/{film.camera}/from_timestamp": 0.0,
                f"videos/{film.camera}/to_timestamp": n / film.fps,
            }
        for name, measured in _statistics([item]).items():
            row |= {f"stats/{name}/{measure}": value for measure, value in measured.items()}
        rows.append(row | {"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0})
        first += n
    return parquet_bytes(pa.Table.from_pylist(rows))


def _statistics(recorded: Sequence[_Recorded]) -> dict[str, dict[str, Any]]:
    state = np.concatenate([item.state for item in recorded])
    action = np.concatenate([np.vstack([r.state[1:], r.state[-1:]]) for r in recorded])
    timestamps = np.concatenate([item.timestamps for item in recorded])[:, None]
    vectors = {"observation.state": state, "action": action, "timestamp": timestamps}
    found = {name: _measures(values) for name, values in vectors.items()}
    for films in zip(*(item.films for item in recorded), strict=True):  # those of a camera
        found[films[0].camera] = _colours(films)
    return found


def _measures(values: npt.NDArray[Any]) -> dict[str, Any]:
    """Statistics of each column of values, shape (n, k)."""
    values = values.astype(np.float64)
    return {
        "min": values.min(0).tolist(),
        "max": values.max(0).tolist(),
        "mean": values.mean(0).tolist(),
        "std": values.std(0).tolist(),
        "count": [len(values)],
        **{f"q{round(q * 100):02d}": np.quantile(values, q, axis=0).tolist() for q in QUANTILES},
    }


def _colours(films: Sequence[_Film]) -> dict[str, Any]:
    """Statistics of red, green and blue from 0 to 1 in the first frames of videos, (3, 1, 1)."""
    pictures = []
    for film in films:
        info = probe(film.file)
        frame = first_picture(film.file, info, whole(info))
        pictures.append(frame[::4, ::4].reshape(-1, 3) / 255)
    measured = _measures(np.concatenate(pictures))
    return {
        name: value if name == "count" else [[[number]] for number in value]
        for name, value in measured.items()
    }


def _info(
    corpus: Corpus, recorded: Sequence[_Recorded], tasks: Sequence[str], fps: int
) -> dict[str, Any]:
    vector = {"dtype": "float32", "shape": [len(NAMES)], "names": list(NAMES)}
    features: dict[str, Any] = {"observation.state": vector, "action": vector}
    films = recorded[0].films
    for film in films:
        height, width = film.size
        features[film.camera] = {
            "dtype": "video",
            "shape": [height, width, 3],
            "names": ["height", "width", "channels"],
            "info": {
                "video.height": height, "video.width": width, "video.codec": "h264",
                "video.pix_fmt": "yuv420p", "is_depth_map": False, "video.fps": fps,
                "video.channels": 3, "has_audio": False,
            },
        }  # fmt: skip
    one = {"shape": [1], "names": None}
    features["timestamp"] = {"dtype": "float32", **one}
    for name in ("frame_index", "episode_index", "index", "task_index"):
        features[name] = {"dtype": "int64", **one}
    features |= {
        language_rows.PERSISTENT: language_rows.FEATURE,
        language_rows.EVENTS: language_rows.FEATURE,
    }
    return {
        "codebase_version": NEW,
        "robot_type": " ".join(recorded[0].context.agent.labels) or None,
        "total_episodes": len(recorded),
        "total_frames": sum(len(item.timestamps) for item in recorded),
        "total_tasks": len(tasks),
        "chunks_size": FILES_IN_CHUNK,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": fps,
        "splits": {"train": f"0:{len(recorded)}"},
        "data_path": DATA,
        "video_path": VIDEOS if films else None,
        "features": features,
    }


def _by_context(folders: Sequence[Path]) -> dict[str, tuple[_Film, ...]]:
    """Return the rendered videos by the ids of their contexts, those of each camera in order."""
    cameras = [_films(folder) for folder in folders]
    by_camera: dict[str, Path] = {}
    every = [
        (folder, film)
        for folder, films in zip(folders, cameras, strict=True)
        for film in films.values()
    ]
    for folder, film in every:
        if by_camera.setdefault(film.camera, folder) != folder:
            raise FormatError(
                "two folders have videos of one camera",
                where=f"--videos {by_camera[film.camera]} --videos {folder}",
                fix="render one with another --camera",
            )
    if len({film.fps for _, film in every}) > 1:
        raise FormatError(
            "the videos differ in frames a second",
            where=", ".join(map(str, folders)),
            fix="render them alike",
        )
    names = dict.fromkeys(name for films in cameras for name in films)
    for name in names:
        for folder, films in zip(folders, cameras, strict=True):
            if name not in films:
                fix = "render it there, too, or take it out of the others"
                raise FormatError(f"there is no video of {name}", where=str(folder), fix=fix)
        counts = {films[name].frames for films in cameras}
        if len(counts) > 1:
            what = f"the videos of {name} differ in their frames: {sorted(counts)}"
            raise FormatError(what, where=", ".join(map(str, folders)), fix=_RENDER)
    return {name: tuple(films[name] for films in cameras) for name in names}


def _films(folder: Path) -> dict[str, _Film]:
    """Return the rendered videos in a folder, of one camera, by the id of their context."""
    films: dict[str, _Film] = {}
    for file in sorted(folder.glob("*/manifest.json")):
        try:
            told = msgspec.json.decode(regular_file.read_bytes(file), type=_Manifest)
        except (OSError, msgspec.DecodeError) as error:
            raise FormatError(
                f"the manifest can't be read: {error}", where=str(file), fix=_RENDER
            ) from error
        settings = told.settings
        if settings.speed != 1 or settings.skip_idle:
            raise FormatError(
                "the video shows other times than the log, so a frame has no state",
                where=str(file),
                fix="render it without --speed and --skip-idle",
            )
        width, height = settings.size
        video = file.with_name("video.mp4")
        camera = f"{IMAGES}.{settings.camera}"
        films[told.id] = _Film(video, camera, told.frames, told.fps, (height, width))
    if len({(film.camera, film.size) for film in films.values()}) > 1:
        raise FormatError(
            "the videos differ in camera or size", where=str(folder), fix="render them alike"
        )
    return films


def _check(film: _Film) -> None:
    """Check that a video is whole and has the frames of its manifest."""
    info = probe(film.file)
    what = info.problem
    if not what and len(info.frame_times) != film.frames:
        what = f"it has {len(info.frame_times)} frames, and its manifest says {film.frames}"
    if what:
        raise FormatError(f"the video isn't whole: {what}", where=str(film.file), fix=_RENDER)


class _Settings(msgspec.Struct, frozen=True):
    size: tuple[int, int]
    camera: Literal["overview", "track", "follow", "operator"]
    speed: float = 1.0
    skip_idle: bool = False


class _Manifest(msgspec.Struct, frozen=True):
    id: str
    frames: int
    fps: int
    settings: _Settings


def _lines(rows: Iterable[Mapping[str, Any]]) -> bytes:
    return msgspec.json.Encoder().encode_lines(list(rows))


def _card(corpus: Corpus, place: str = "`language_persistent`") -> str:
    head = "license: other\ntask_categories: [robotics]\ntags: [LeRobot]\n"
    head += "configs:\n- config_name: default\n  data_files: data/*/*.parquet\n"
    return (
        f"---\n{head}---\n\n# {corpus.name}\n\nA LeRobot dataset made of a language corpus. "
        f"Source: {corpus.source or 'not told'}. Licence: {corpus.licence or 'not told'}.\n\n"
        "The state is the robot's position in metres and its heading in radians, the action the "
        f"state at the next frame.\nLanguage is in {place}: other wordings of the "
        "task, subtasks and plans.\n"
    )


def _json(value: object) -> bytes:
    return msgspec.json.format(msgspec.json.encode(value), indent=4) + b"\n"
