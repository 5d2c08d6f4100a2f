"""The file trajectories.npz: every trajectory once, end to end in four arrays.

``t`` (n,), ``xyz`` (n, 3) and ``yaw`` (n,) hold all poses; trajectory ``i`` is the poses
from ``offsets[i]`` up to ``offsets[i + 1]``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from corpus_tools.corpus.corpus_records import TRAJECTORIES
from g3.errors import FormatError
from g3.groundings import Trajectory
from g3.storage import array_file
from g3.storage.array_file import Field

Arrays = dict[str, npt.NDArray[Any]]
_FIELDS = {
    "offsets": Field("<i8"),
    "t": Field("<f8"),
    "xyz": Field("<f8", dimensions=2),
    "yaw": Field("<f8"),
}


def pack(trajectories: Sequence[Trajectory]) -> Arrays:
    """Lay trajectories end to end."""
    lengths = [len(trajectory) for trajectory in trajectories]
    return {
        "offsets": np.cumsum([0, *lengths], dtype="<i8"),
        "t": np.concatenate([np.empty(0), *(x.t for x in trajectories)]).astype("<f8"),
        "xyz": np.concatenate([np.empty((0, 3)), *(x.xyz for x in trajectories)]).astype("<f8"),
        "yaw": np.concatenate([np.empty(0), *(x.yaw for x in trajectories)]).astype("<f8"),
    }


def to_bytes(arrays: Arrays) -> bytes:
    """Return the file's bytes, the same for the same arrays."""
    return array_file.write_arrays({name: arrays[name] for name in _FIELDS}, compressed=False)


def read_arrays(path: Path) -> Arrays:
    """Read the file; FormatError if it is missing, cut off or doesn't hold the four arrays."""
    fix = "restore the file, or import the corpus again"
    if not path.is_file():
        raise FormatError("the file is missing", where=str(path), fix=fix)
    arrays = array_file.read_arrays(path, _FIELDS, where=str(path), fix=fix, error=FormatError)
    offsets, t, xyz, yaw = (arrays[name] for name in _FIELDS)
    n = len(t)
    if not len(offsets) or xyz.shape != (n, 3) or yaw.shape != (n,):
        raise FormatError(
            "the arrays' shapes don't fit: offsets (k,), t (n,), xyz (n, 3) and yaw (n,) "
            "are expected",
            where=str(path),
            fix=fix,
        )
    if offsets[0] != 0 or offsets[-1] != n or (np.diff(offsets) < 0).any():
        raise FormatError("offsets don't divide the poses", where=f"{path}: offsets", fix=fix)
    return arrays


def as_lists(arrays: Arrays) -> Iterator[dict[str, Any]]:
    """Yield the poses of each trajectory as lists, by the names of the arrays."""
    for start, end in pairwise(arrays["offsets"].tolist()):
        yield {name: arrays[name][start:end].tolist() for name in ("t", "xyz", "yaw")}


def unpack_one(arrays: Arrays, index: int) -> Trajectory:
    """Trajectory number `index`; FormatError if it has no poses, isn't finite or runs backwards."""
    start, end = arrays["offsets"][index : index + 2]
    try:
        return Trajectory(
            t=arrays["t"][start:end], xyz=arrays["xyz"][start:end], yaw=arrays["yaw"][start:end]
        )
    except ValueError as error:
        raise FormatError(
            str(error),
            where=f"{TRAJECTORIES}: trajectory {index}",
            fix="restore the file, or correct the values",
        ) from error
