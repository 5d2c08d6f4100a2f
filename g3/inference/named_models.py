"""Trained models by a name or a path.

Installed distributions name models in the entry point group ``g3.models``. Each entry point is a
function without arguments that gives a :class:`~g3.learning.grounding_model.GroundingModel`; it may
train it when it is first asked for.
"""

from __future__ import annotations

import importlib.metadata
from pathlib import Path
from typing import cast

from g3.errors import ModelError
from g3.learning.grounding_model import GroundingModel
from g3.learning.model_file import model_files

ENTRY_POINT_GROUP = "g3.models"


def open_model(model: GroundingModel | Path | str) -> GroundingModel:
    """Read a model, or get one by its name.

    Parameters
    ----------
    model
        ``NAME``, ``NAME.npz`` or ``NAME.json`` of a file; where there is none, the name of a model,
        such as ``warehouse``. A model is given back as it is.

    Raises
    ------
    ModelError
        If there is neither, or the file can't be used.
    """
    if isinstance(model, GroundingModel):
        return model
    if any(Path(file).exists() for file in model_files(model)):
        return GroundingModel.load(model)
    named = {p.name: p for p in importlib.metadata.entry_points(group=ENTRY_POINT_GROUP)}
    if str(model) not in named:
        more = "or train one and save() it"
        raise ModelError.unknown("file or model", str(model), sorted(named), more=more)
    return cast("GroundingModel", named[str(model)].load()())
