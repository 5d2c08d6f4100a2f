"""The interface that models share: scikit-learn's, without scikit-learn.

The constructor takes hyperparameters and keeps them as they are. `fit` learns, returns the model,
and keeps what it has learned in attributes whose names end in ``_``.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from g3.errors import ModelError
from g3.storage import regular_file

E = TypeVar("E", bound="Estimator")


def read_bytes(path: Path, *, fix: str) -> bytes:
    """Read a model's file.

    Raises
    ------
    ModelError
        If it can't be read.
    """
    try:
        return regular_file.read_bytes(path)
    except OSError as error:
        raise ModelError(
            f"the model can't be read: {error.strerror}", where=str(path), fix=fix
        ) from error


class NotFittedError(ModelError, AttributeError):
    """A model that is used before it has learned anything."""


class NoSuchParameterError(ModelError, ValueError):
    """A hyperparameter that a model doesn't have."""


@dataclass(eq=False)
class Estimator:
    """A model with hyperparameters, which are its fields, and learned attributes."""

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Return hyperparameters: ``type(model)(**model.get_params())`` is the same, unfitted."""
        return {field.name: getattr(self, field.name) for field in fields(self) if field.init}

    def set_params(self: E, **params: Any) -> E:
        """Set hyperparameters, and return the model.

        Raises
        ------
        ModelError
            If there is no such hyperparameter.
        """
        parameters = self.get_params()
        for name, value in params.items():
            if name not in parameters:
                raise NoSuchParameterError.unknown("hyperparameter", name, parameters)
            setattr(self, name, value)
        return self

    def __sklearn_tags__(self) -> Any:
        """Describe the model to scikit-learn: its inputs are lists, not arrays."""
        from sklearn.utils import ClassifierTags, InputTags, Tags, TargetTags  # noqa: PLC0415

        is_classifier = hasattr(type(self), "classes_")
        return Tags(
            estimator_type="classifier" if is_classifier else None,
            classifier_tags=ClassifierTags(multi_class=False) if is_classifier else None,
            target_tags=TargetTags(required=False),
            input_tags=InputTags(two_d_array=False),
            no_validation=True,
        )

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Say what to do where something learned is missing."""
            what = f"{type(self).__name__} has no attribute {name!r}"
            if name.startswith("_") or not name.endswith("_"):
                raise AttributeError(what)
            raise NotFittedError(
                f"this {type(self).__name__} isn't fitted yet",
                fix="call its fit(), or read one from a file with load()",
            )
