"""Files of what a parser has learned."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np
import numpy.typing as npt

from g3.errors import ModelError
from g3.language.parsing.arc_model import FARTHEST, ArcModel
from g3.language.parsing.encoder import (
    LAYER_FIELDS,
    Encoder,
    default_encoder,
    layer_arrays,
    with_last_layers,
)
from g3.storage.array_file import Array, Field, read_arrays, write_arrays

VERSION = 4
RETRAIN = "train it again with 'ct train parser'"
_DIMENSIONS = {"root": 1, "distances": 1, "label_forms": 3}
_WEIGHTS = tuple(f.name for f in fields(ArcModel) if f.name != "labels")
_FIELDS = {
    "form": Field("|u1"),
    "card": Field("|u1"),
    **{name: Field("<f2", _DIMENSIONS.get(name, 2), finite=True) for name in _WEIGHTS},
}


def to_bytes(model: ArcModel, card: Mapping[str, object], encoder: Encoder) -> bytes:
    """Write a parser as an archive of NumPy arrays.

    Weights are rounded to half precision, those of the layers to integers.

    Parameters
    ----------
    model
        The choice of arcs.
    card
        Notes on the training.
    encoder
        The encoder; its layers are written if they aren't those that its file has.
    """
    form = {"version": VERSION, "encoder": encoder.digest, "labels": model.labels}
    arrays: dict[str, Array] = {"form": _text(form), "card": _text(dict(card))}
    arrays |= {name: getattr(model, name).astype(np.float16) for name in _WEIGHTS}
    if encoder.changed:
        last = encoder.layers[-encoder.changed :]
        arrays |= layer_arrays(last, encoder.norms[-4 * encoder.changed :])
    return write_arrays(arrays, sealed=True)


def _text(value: object) -> npt.NDArray[np.uint8]:
    return np.frombuffer(json.dumps(value, sort_keys=True).encode(), dtype=np.uint8)


def from_bytes(content: bytes, *, where: str = "") -> tuple[ArcModel, dict[str, Any], Encoder]:
    """Read a parser: its choice of arcs, the notes on its training, and its encoder.

    Parameters
    ----------
    content
        The bytes that :func:`to_bytes` wrote.
    where
        Name of the file in an error.

    Raises
    ------
    ModelError
        If it is damaged, or was trained with another encoder.
    """
    tuned = b"square_scales.npy" in content
    wanted = _FIELDS | (LAYER_FIELDS if tuned else {})
    arrays = read_arrays(content, wanted, where=where, fix=RETRAIN, error=ModelError)
    try:
        form = json.loads(arrays["form"].tobytes())
        if form["version"] != VERSION or form["encoder"] != default_encoder().digest:
            raise ModelError(
                "the parser was trained by another version of the program",
                where=where,
                fix=RETRAIN,
            )
        weights = {name: arrays[name].astype(np.float32) for name in _WEIGHTS}
        model = ArcModel(tuple(form["labels"]), **weights)
        _check_shapes(model)
        encoder = default_encoder()
        if tuned:
            encoder = with_last_layers(encoder, arrays)
        return model, json.loads(arrays["card"].tobytes()), encoder
    except (KeyError, IndexError, TypeError, ValueError, RecursionError) as error:
        raise ModelError(f"the parser can't be read: {error}", where=where, fix=RETRAIN) from error


def _check_shapes(model: ArcModel) -> None:
    d, a, b = len(model.root), model.arcs.shape[1], model.label_heads.shape[1]
    shapes = {
        "root": (default_encoder().width,),
        "dependents": (d + 1, a),
        "heads": (d + 1, a),
        "arcs": (a + 1, a),
        "distances": (2 * FARTHEST + 1,),
        "label_dependents": (d + 1, b),
        "label_heads": (d + 1, b),
        "label_forms": (b + 1, len(model.labels), b + 1),
    }
    for name, shape in shapes.items():
        if getattr(model, name).shape != shape:
            raise ValueError(f"{name} has the shape {getattr(model, name).shape}")
