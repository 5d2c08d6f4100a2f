"""The bundled corpus with fewer scenarios, for pages that train on all that they are given."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

from tests.docs.blocks import ROOT

SOURCE = ROOT / "datasets/warehouse"
SOME = (
    "court_put_crate_on_trailer",
    "court_take_tires_to_issue",
    "dock_go_to_receiving",
    "dock_pick_up_tires",
    "dock_put_boxes_on_trailer",
    "hall_pick_up_boxes",
    "hall_put_tires_in_storage",
    "yard_put_tires_on_truck",
)
"""Scenarios of all kinds of actions, in four layouts."""


def small_warehouse(target: Path, scenarios: Sequence[str] = SOME) -> Path:
    """Write the sources of some scenarios to a folder.

    Where the folder is called ``warehouse``, it goes before the corpus that comes along.
    """
    shutil.copytree(SOURCE / "layouts", target / "layouts")
    for part in ("dataset.yaml", *(f"scenarios/{name}.yaml" for name in scenarios)):
        (target / part).parent.mkdir(exist_ok=True)
        shutil.copy(SOURCE / part, target / part)
    (target / "logs").symlink_to(SOURCE / "logs")
    return target
