"""What the files of an authored corpus hold, and reading them."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import yaml_rs

from corpus_tools.importers.report import Journal, SourceFile
from g3.errors import FormatError

DATASET = "dataset.yaml"
SCENARIOS = "scenarios"
ROBOT = "forklift"
"""Id of the agent in every context."""

T = TypeVar("T")
Point = tuple[float, float]


class Site(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where the frame of the scenarios at a site lies in the frame of its map."""

    at: Point
    yaw_deg: float = 0.0


class Kind(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A kind of object: its labels, footprint (along and across its heading) and heights."""

    labels: tuple[str, ...]
    size: Point
    heights: Point


class Thing(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An object: where it is, unless the robot carries it, and on whose deck."""

    kind: str
    at: Point | None = None
    yaw_deg: float = 0.0
    deck: str | None = None


class Region(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A place: its middle, size and name on the map, and on whose deck it is."""

    at: Point
    size: Point = (2.0, 2.0)
    yaw_deg: float = 0.0
    deck: str | None = None
    name: str = ""


class Robot(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The robot's first pose, and what is on its forks."""

    at: Point
    yaw_deg: float = 0.0
    carries: str | None = None


class Action(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the robot does; one of the verbs, `carry` with `to`, `put_down` with `at`."""

    drive_to: str | None = None
    pick_up: str | None = None
    carry: str | None = None
    to: str | None = None
    put_down: str | None = None
    at: str | None = None


class Utterance(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A command, its SDC trees in bracket notation and the groundings of its clauses."""

    text: str
    sdcs: str
    groundings: dict[str, str | tuple[str, ...]]


class _DatasetFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    name: str
    source: str
    licence: str
    seed: int
    sites: dict[str, Any]
    kinds: dict[str, Any]
    words: dict[str, Any]


class _ScenarioFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    title: str
    site: str
    robot: Any
    action: Any
    objects: dict[str, Any]
    places: dict[str, Any]
    commands: list[Any]


@dataclass(frozen=True, slots=True)
class Dataset:
    """The file dataset.yaml: what all scenarios share.

    Parameters
    ----------
    name, source, licence
        Of the corpus.
    seed
        Of the random negatives.
    sites, kinds
        By name.
    words
        For each word of leaf OBJECTs the labels of which an object must have at least
        one; no labels mean that any object fits.
    """

    name: str
    source: str
    licence: str
    seed: int
    sites: Mapping[str, Site]
    kinds: Mapping[str, Kind]
    words: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class Scenario:
    """A file of the folder scenarios.

    Parameters
    ----------
    id
        Name of the file without its ending.
    file
        Name of the file in the dataset's folder.
    title
        What happens, in one sentence.
    site
        Name of its site.
    robot, action
        What does what.
    objects, places
        By id.
    commands
        As parsed; :func:`read_utterance` reads one.
    """

    id: str
    file: str
    title: str
    site: str
    robot: Robot
    action: Action
    objects: Mapping[str, Thing]
    places: Mapping[str, Region]
    commands: Sequence[Any]


def read_dataset(folder: Path, journal: Journal) -> Dataset:
    """Read dataset.yaml.

    Raises
    ------
    FormatError
        If it isn't there or can't be read.
    """
    path = folder / DATASET
    if not path.is_file():
        raise FormatError(
            f"this is not an authored corpus: it has no {DATASET}",
            where=str(folder),
            fix="docs/authored-corpora.md tells what the folder holds",
        )
    try:
        value = _parse(path, DATASET, journal)
        shared = _convert(value, _DatasetFile, "")
        return Dataset(
            shared.name,
            shared.source,
            shared.licence,
            shared.seed,
            sites=_by_id(shared.sites, Site, "sites"),
            kinds=_by_id(shared.kinds, Kind, "kinds"),
            words=_by_id(shared.words, tuple[str, ...], "words"),
        )
    except FormatError as error:
        where = f"{path}: {error.where}" if error.where else str(path)
        raise FormatError(error.what, where=where, fix=error.fix) from error


def scenario_files(folder: Path) -> list[Path]:
    """The files of the scenarios, in the order of their names."""
    return sorted((folder / SCENARIOS).glob("*.yaml"))


def read_scenario(path: Path, journal: Journal) -> Scenario:
    """Read a scenario, but for its commands.

    Raises
    ------
    FormatError
        If it can't be read; ``where`` is the field.
    """
    file = f"{SCENARIOS}/{path.name}"
    whole = _convert(_parse(path, file, journal), _ScenarioFile, "")
    for name in (*whole.objects, *whole.places):
        if name == ROBOT or (name in whole.objects and name in whole.places):
            raise FormatError(
                f"the id {name!r} is taken", where=name, fix="give everything an id of its own"
            )
    return Scenario(
        id=path.stem,
        file=file,
        title=whole.title,
        site=whole.site,
        robot=_convert(whole.robot, Robot, "robot"),
        action=_convert(whole.action, Action, "action"),
        objects=_by_id(whole.objects, Thing, "objects"),
        places=_by_id(whole.places, Region, "places"),
        commands=whole.commands,
    )


def read_utterance(value: Any) -> Utterance:
    """Read a command.

    Raises
    ------
    FormatError
        If it has another form; ``where`` is the field.
    """
    utterance = _convert(value, Utterance, "")
    if not utterance.text.strip():
        raise FormatError("the command has no text", where="text", fix="add it")
    return utterance


def _parse(path: Path, file: str, journal: Journal) -> Any:
    try:
        content = path.read_bytes()
        value = yaml_rs.loads(content.decode("utf-8"), parse_datetime=False)
    except OSError as error:
        raise FormatError(
            f"the file can't be read: {error.strerror}", fix="check its permissions"
        ) from error
    except UnicodeDecodeError as error:
        raise FormatError(f"the file is not UTF-8 text: {error}", fix="save it as UTF-8") from error
    except yaml_rs.YAMLDecodeError as error:
        first_line, *_ = str(error).splitlines()
        raise FormatError(f"the file is not valid: {first_line}", fix="correct it") from error
    records = len(value.get("commands") or ()) if isinstance(value, dict) else 0
    journal.files.append(SourceFile(file, hashlib.sha256(content).hexdigest(), records))
    return value


def _by_id(values: Mapping[str, Any], record_type: type[T], where: str) -> dict[str, T]:
    return {name: _convert(value, record_type, f"{where}.{name}") for name, value in values.items()}


def _convert(value: Any, record_type: type[T], where: str) -> T:
    try:
        return msgspec.convert(value, record_type)
    except msgspec.ValidationError as error:
        # msgspec ends its message with the field: "... - at `$.at[0]`"
        found = re.fullmatch(r"(?s)(.*?)(?: - at `(?:key in )?\$\.?(.*)`)?", str(error))
        what, field = (found[1], found[2]) if found else (str(error), None)
        raise FormatError(
            what[:1].lower() + what[1:],
            where=".".join(part for part in (where, field) if part),
            fix="docs/authored-corpora.md tells the form",
        ) from error
