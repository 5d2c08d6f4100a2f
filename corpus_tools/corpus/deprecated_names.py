"""Names that stay for one version after something has taken their place."""

from __future__ import annotations

import warnings
from collections.abc import Mapping


def deprecated_name(
    module: str, name: str, replacements: Mapping[str, tuple[str, object]]
) -> object:
    """Return the replacement of a module's old name, with a DeprecationWarning.

    Parameters
    ----------
    replacements
        For each old name the new one as users write it, and what it stands for.

    Raises
    ------
    AttributeError
        If the module never had such a name.
    """
    if name not in replacements:
        raise AttributeError(f"module {module!r} has no attribute {name!r}")
    new, value = replacements[name]
    message = f"{module}.{name} goes with the next version; use {new}"
    warnings.warn(message, DeprecationWarning, stacklevel=3)
    return value
