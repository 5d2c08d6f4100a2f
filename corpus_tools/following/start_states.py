"""Starts at which commands are followed: of a scenario, or of a context of a corpus."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.world.scenarios.contexts import scenario_context
from corpus_tools.world.scenarios.scenario_reading import (
    dataset_folder,
    read_scenario,
    scenario_file,
)
from g3.actions.robot_state import State, start_state
from g3.errors import CorpusError

DATASET = "warehouse"


def scenario_start(name_or_path: str | Path) -> State:
    """Return the start of a scenario: a file, or a bundled one by its name."""
    scenario = read_scenario(scenario_file(str(name_or_path), dataset_folder(DATASET)))
    layout = scenario.layout
    frame = (*layout.at, float(np.deg2rad(layout.yaw_deg)))
    return replace(start_state(scenario_context(scenario)), site=layout.site, frame=frame)


def context_start(name: str) -> State:
    """Return the start of a context, ``CORPUS:ID``."""
    corpus, _, key = name.rpartition(":")
    if not corpus:
        raise CorpusError(
            "a context is named by its corpus and its id", where=name, fix="CORPUS:ID"
        )
    contexts = open_corpus(corpus).contexts
    if key not in contexts:
        raise CorpusError.unknown(
            "context",
            key,
            sorted(contexts),
            where=corpus,
            more=f"ct corpus show {corpus} lists them",
        )
    return start_state(contexts[key])
