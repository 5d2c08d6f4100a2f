"""Logs for tests of the importer: things slide straight to where their script brings them."""

from __future__ import annotations

import numpy as np

from corpus_tools.importers.authored.authored_files import ends
from corpus_tools.logs.log_writing import write_log
from corpus_tools.world.scenarios.contexts import scenario_context, scenario_places
from corpus_tools.world.scenarios.scenario_logs import FINGERPRINT, fingerprint
from corpus_tools.world.scenarios.scenario_reading import read_scenario, scenario_files
from corpus_tools.world.state.recording import NS_PER_S, Recording, upright

ROBOT_STEP_M = 0.5


def write_logs(folder):
    """Write a log for every scenario of a dataset."""
    (folder / "logs").mkdir(exist_ok=True)
    for path in scenario_files(folder).values():
        scenario = read_scenario(path)
        metadata = {FINGERPRINT: fingerprint(scenario)}
        log = folder / "logs" / f"{scenario.id}.mcap"
        write_log(sliding(scenario), log, name=scenario.id, metadata=metadata)


def sliding(scenario):
    """A recording of three moments."""
    context = scenario_context(scenario)
    places, goals = scenario_places(scenario), ends(scenario)
    begin = np.array([item.trajectory.xyz[0] for item in context.objects])
    end = begin.copy()
    for i, item in enumerate(context.objects):
        if item.id == context.agent_id or item.id == scenario.robot.carries:
            end[i, 0] += ROBOT_STEP_M
        if item.id in goals:
            end[i, :2] = places[goals[item.id]].prism.xy.mean(axis=0)
    yaw = np.array([item.trajectory.yaw[0] for item in context.objects])
    return Recording(
        start=context,
        t_ns=np.arange(3) * NS_PER_S,
        position=np.array([begin, (begin + end) / 2, end]),
        orientation=np.tile(upright(yaw), (3, 1, 1)),
        fork_height_m=np.full(3, 0.07),
    )
