"""Sources of videos: scenarios, which are executed, and contexts, which are replayed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.world.scenarios.execution import recorded
from corpus_tools.world.scenarios.scenario_logs import FINGERPRINT, fingerprint
from corpus_tools.world.scenarios.scenario_reading import (
    dataset_folder,
    read_scenario,
    scenario_file,
    scenario_files,
)
from corpus_tools.world.state.onlookers import with_onlookers
from corpus_tools.world.state.recording import Recording
from corpus_tools.world.state.replay import replay
from g3.errors import FormatError
from g3.groundings import Context
from g3.short_repr import short_repr

RATE_HZ = 50


@short_repr
@dataclass(frozen=True, slots=True)
class ScenarioItem:
    """A scenario's file."""

    name: str
    path: Path


@dataclass(frozen=True, slots=True)
class ContextItem:
    """A context of a corpus."""

    name: str
    corpus: str
    context_id: str


@short_repr
@dataclass(frozen=True, slots=True)
class Story:
    """Content of a video."""

    id: str
    """Identifier of the scenario or the context."""
    title: str
    """Summary in a sentence; empty if none is given."""
    fingerprint: str
    """Digest of all that determines the events."""
    metadata: Mapping[str, str]
    """Metadata that the log keeps."""
    record: Callable[[], Recording]
    """Makes it happen, and gives the recording."""
    site: str = "yard"
    """Surroundings: one of :data:`~corpus_tools.world.looks.site_looks.SITES`."""


Item: TypeAlias = ScenarioItem | ContextItem


def scenario_items(dataset: str, names: tuple[str, ...]) -> list[Item]:
    """Return scenarios by their names or files; all of a dataset if none are given.

    FormatError if one isn't there, or two have the same name.
    """
    folder = dataset_folder(dataset)
    paths = [scenario_file(name, folder) for name in names] or scenario_files(folder).values()
    items: dict[str, Item] = {}
    for path in paths:
        other = items.setdefault(path.stem, ScenarioItem(path.stem, path))
        if isinstance(other, ScenarioItem) and other.path != path:
            raise FormatError(
                f"two scenarios are called {path.stem}", where=str(path), fix="rename a file"
            )
    return list(items.values())


def context_items(corpus: str) -> list[Item]:
    """Return the contexts of a corpus; FormatError if it can't be read."""
    return [
        ContextItem(key.replace("/", "-"), corpus, key)
        for key in sorted(open_corpus(corpus).contexts)
    ]


def story_of(item: Item) -> Story:
    """Read an item's story; FormatError if something in it is wrong."""
    if isinstance(item, ContextItem):
        return _replayed(open_corpus(item.corpus).contexts[item.context_id], item.corpus)
    scenario = read_scenario(item.path)
    digest = fingerprint(scenario)
    return Story(
        scenario.id,
        scenario.title,
        digest,
        {FINGERPRINT: digest},
        lambda: with_onlookers(recorded(scenario, RATE_HZ)),
        scenario.layout.site,
    )


def _replayed(context: Context, corpus: str) -> Story:
    return Story(
        context.id,
        "",
        Corpus.build("", contexts=[context], commands=(), annotations=()).hash,
        {"corpus": Path(corpus).name},
        lambda: replay(context, RATE_HZ),
    )
