"""What an extractor has learned, as bytes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from g3.errors import ModelError
from g3.language.parsing.attachment import AttachmentModel
from g3.language.parsing.role_model import TABLE_BITS, RoleModel, Weights, weigh
from g3.language.parsing.spacy_pipeline import VECTOR
from g3.language.parsing.word_features import MOVE_TEMPLATES, TEMPLATES
from g3.language.parsing.word_roles import ROLES
from g3.storage.array_file import DIGEST, Array, Field, read_arrays, write_arrays

VERSION, UNSEALED_VERSION = 3, 2
"""Files of the second can be read; the first adds a digest of everything."""
RETRAIN = "train it again with 'ct train sdc'"
_FIELDS = {
    "form": Field("|u1"),
    "card": Field("|u1"),
    "role_keys": Field("<i4"),
    "role_weights": Field("<f2", dimensions=2, finite=True),
    "move_keys": Field("<i4"),
    "move_weights": Field("<f2", dimensions=3, finite=True),
    "vector_weights": Field("<f2", dimensions=2, finite=True),
    "attachment_keys": Field("<i4"),
    "attachment_weights": Field("<f2", finite=True),
}
SMALL = 1e-3
"""Weights below are left out."""


def to_bytes(roles: RoleModel, attachments: AttachmentModel, card: Mapping[str, object]) -> bytes:
    """Write an extractor as an archive of NumPy arrays; weights are rounded to half precision."""
    buckets = sorted(attachments.weights)
    role_keys, role_weights = _arrays(roles.roles)
    move_keys, move_weights = _arrays(roles.moves)
    values = [attachments.weights[bucket] for bucket in buckets]
    arrays: dict[str, Array] = {
        "form": _form(VERSION),
        "card": _text(dict(card)),
        "role_keys": role_keys,
        "role_weights": role_weights,
        "move_keys": move_keys,
        "move_weights": move_weights,
        "vector_weights": roles.vectors.astype(np.float16),
        "attachment_keys": np.array(buckets, dtype=np.int32),
        "attachment_weights": np.array(values, dtype=np.float16),
    }
    return write_arrays(arrays, sealed=True)


def _form(version: int) -> npt.NDArray[np.uint8]:
    """What weights are of, which must be the same where they are read."""
    templates, moves = ([" ".join(one) for one in of] for of in (TEMPLATES, MOVE_TEMPLATES))
    return _text(
        {"version": version, "roles": ROLES, "templates": templates, "move_templates": moves}
    )


def _text(value: object) -> npt.NDArray[np.uint8]:
    return np.frombuffer(json.dumps(value, sort_keys=True).encode(), dtype=np.uint8)


def _arrays(weights: Weights) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.float16]]:
    values = weights.values[:-1]
    kept = np.flatnonzero(np.abs(values).reshape(len(values), -1).max(axis=1, initial=0) > SMALL)
    return weights.keys[kept].astype(np.int32), values[kept].astype(np.float16)


def from_bytes(
    content: bytes, *, where: str = ""
) -> tuple[RoleModel, AttachmentModel, dict[str, Any]]:
    """Read an extractor.

    Parameters
    ----------
    content
        What :func:`to_bytes` wrote.
    where
        What to call it in an error.

    Raises
    ------
    ModelError
        If it is damaged, or was written for other roles or features than there are.
    """
    arrays = read_arrays(content, _FIELDS, where=where, fix=RETRAIN, error=ModelError)
    try:
        form = _form(VERSION if DIGEST in arrays else UNSEALED_VERSION)
        if arrays["form"].tobytes() != form.tobytes():
            raise ModelError(
                "the extractor was trained by another version of the program",
                where=where,
                fix=RETRAIN,
            )
        roles = RoleModel(
            _weights(arrays, "role", (len(ROLES),)),
            _weights(arrays, "move", (len(ROLES) + 1, len(ROLES))),
            _vectors(arrays["vector_weights"]),
        )
        return roles, _attachments(arrays), json.loads(arrays["card"].tobytes())
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise ModelError(
            f"the extractor can't be read: {error}", where=where, fix=RETRAIN
        ) from error


def _weights(
    arrays: dict[str, npt.NDArray[np.generic]], name: str, shape: tuple[int, ...]
) -> Weights:
    keys = arrays[f"{name}_keys"].astype(np.intp)
    values = arrays[f"{name}_weights"].astype(float)
    if values.shape != (len(keys), *shape):
        raise ValueError(f"{name}_weights has the shape {values.shape}")
    if len(keys) and not (keys.min() >= 0 and keys.max() < 1 << TABLE_BITS):
        raise ValueError(f"{name}_keys has keys out of range")
    return weigh(keys, values)


def _attachments(arrays: dict[str, npt.NDArray[np.generic]]) -> AttachmentModel:
    keys = arrays["attachment_keys"].astype(int)
    values = arrays["attachment_weights"].astype(float)
    if values.shape != keys.shape:
        raise ValueError("attachment_weights has another shape")
    return AttachmentModel(dict(zip(keys.tolist(), values.tolist(), strict=True)))


def _vectors(weights: npt.NDArray[np.generic]) -> npt.NDArray[np.float32]:
    values = weights.astype(np.float32)
    if values.shape != (VECTOR, len(ROLES)):
        raise ValueError(f"vector_weights has the shape {values.shape}")
    return values
