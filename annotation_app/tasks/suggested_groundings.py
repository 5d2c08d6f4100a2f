"""What a trained model proposes for the things and places of a command.

The model is the installation's own (``--model`` of ``ct annotate serve``); without one there are no
suggestions, for training the bundled model takes minutes. It is never asked when something
happens in a video: people choose that without a preset.
"""

from __future__ import annotations

import functools
import threading
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import scene_of
from annotation_app.store.installation import installation
from annotation_app.store.models import Item, Record
from annotation_app.tasks.exported_groundings import as_answered
from g3.errors import CorpusError
from g3.groundings import Context
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import from_json

if TYPE_CHECKING:
    from g3.inference.grounder import Grounder

_ONE_AT_A_TIME = threading.Lock()


def suggested(session: Session, item: Item) -> Record | None:
    """``{"groundings": {node: grounding}}``; None without a model, or if it finds nothing to do.

    An item may come with a suggestion of its own.
    """
    given: Record | None = item.payload.get("suggestion")
    model = installation().config.model
    if given is not None or model is None:
        return given
    scene = scene_of(session, item.study_id, item.payload["video"])
    if scene.is_picture:  # where things lie in a picture is no world
        return None
    return _proposed(model, from_json(item.payload["sdcs"]), scene.context)


def _proposed(model: Path, sdcs: tuple[SDC, ...], context: Context) -> Record | None:
    try:
        with _ONE_AT_A_TIME:
            plan = _grounder(model).follow(sdcs, context, least=0.0, insist=True).plan
    except CorpusError:  # the model's file can't be read, or the clauses can't be followed
        return None
    found = {
        str(clause.node): as_answered(clause.group, context)
        for clause in (plan.groundings if plan else ())
        if clause.sdc.type in ("OBJECT", "PLACE") and not clause.sdc.is_implicit
    }
    named = {node: one for node, one in found.items() if one["objects"] or one["places"]}
    return {"groundings": named} if named else None


@functools.lru_cache(maxsize=1)
def _grounder(model: Path) -> Grounder:
    from g3.inference.grounder import Grounder  # noqa: PLC0415 - slow to import
    from g3.learning.grounding_model import GroundingModel  # noqa: PLC0415 - as above

    return Grounder.load(GroundingModel.load(model))
