"""Named arrays as bytes (.npz), read so that any damage is an error that says where it is.

:func:`numpy.load` believes what a file says of itself: a flipped bit can make it ask for a
terabyte, or raise any of a dozen exceptions. Here an array's header is compared with what is
expected and with the file's size before NumPy reads the array, and every error names it.
"""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping
from math import prod
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from numpy.lib import format as npy

from g3.errors import CorpusError
from g3.storage import regular_file

Array: TypeAlias = npt.NDArray[Any]

DIGEST = "digest"
"""Name of the array that holds the digest of all others, in files that have one."""
INFLATION, ALLOWANCE = 100, 1 << 24
"""Largest size of an array: a multiple of its stored size, plus a number of bytes."""


class Field(NamedTuple):
    """Requirements on an array of a file.

    Parameters
    ----------
    dtype
        Its type, such as ``<f8``; one letter stands for all types of a kind (``U``: text).
    dimensions
        Number of dimensions.
    finite
        True if all its numbers must be finite.
    """

    dtype: str
    dimensions: int = 1
    finite: bool = False


class _DamagedError(ValueError):
    """Damage to one array."""


def write_arrays(
    arrays: Mapping[str, Array], *, compressed: bool = True, sealed: bool = False
) -> bytes:
    """Return arrays as the bytes of an .npz file; equal arrays give equal bytes.

    Parameters
    ----------
    compressed
        True to take time to make it small.
    sealed
        True to add a digest of all of them, which :func:`read_arrays` checks.
    """
    out = io.BytesIO()
    seal = {DIGEST: digest_of(arrays)} if sealed else {}
    save = np.savez_compressed if compressed else np.savez
    save(out, allow_pickle=False, **seal, **arrays)
    return out.getvalue()


def read_arrays(
    source: bytes | Path,
    fields: Mapping[str, Field],
    *,
    where: str,
    fix: str,
    error: type[CorpusError],
) -> dict[str, Array]:
    """Read the arrays of a file; others that it holds are left alone.

    Parameters
    ----------
    source
        All bytes of the .npz file; or where it is, so that it isn't held beside its arrays.
    fields
        The arrays to read, by name; all of them, if the file has a digest.
    where, fix, error
        Name of the file in an error, its fix, and the class of error to raise.

    Returns
    -------
    dict
        The arrays, which can be written to; and `DIGEST`, if the file has one.

    Raises
    ------
    CorpusError
        An `error` that names the file and the array, for any damage.
    """
    name = ""
    try:
        stored = len(source) if isinstance(source, bytes) else source.stat().st_size
        with (
            (
                io.BytesIO(source) if isinstance(source, bytes) else regular_file.opened(source)
            ) as file,
            zipfile.ZipFile(file) as archive,
        ):
            members = _members(archive)
            arrays = {}
            for name, field in fields.items():
                arrays[name] = _read(archive, members, name, field, stored)
            if DIGEST in members:
                name = DIGEST
                content = _read(archive, members, name, Field("|u1"), stored)
                if content.tobytes() != digest_of(arrays).tobytes():
                    raise _DamagedError("the arrays are not those that were written")
                arrays[DIGEST] = content
    except Exception as problem:  # a damaged file can raise anything
        what = " ".join(str(problem).split()) or type(problem).__name__
        if not isinstance(problem, _DamagedError):
            what = f"the array{'' if name else 's'} can't be read: {what}"
        raise error(what, where=f"{where}: {name}" if name else where, fix=fix) from problem
    return arrays


def _members(archive: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    members: dict[str, zipfile.ZipInfo] = {}
    for info in archive.infolist():
        if info.filename in members:
            raise _DamagedError(f"two arrays are called {info.filename.removesuffix('.npy')!r}")
        members[info.filename] = info
    return {name.removesuffix(".npy"): info for name, info in members.items()}


def _read(
    archive: zipfile.ZipFile,
    members: Mapping[str, zipfile.ZipInfo],
    name: str,
    field: Field,
    stored: int,
) -> Array:
    if name not in members:
        raise _DamagedError("the array is missing")
    info = members[name]
    if info.file_size > INFLATION * stored + ALLOWANCE:
        raise _DamagedError(
            f"the array can't be read: it promises {info.file_size} bytes, "
            f"in a file of {stored} bytes"
        )
    with archive.open(info) as stream:
        npy.read_magic(stream)
        shape, _, dtype = npy.read_array_header_1_0(stream)
        wanted = field.dtype if len(field.dtype) == 1 else np.dtype(field.dtype).str
        if wanted not in (dtype.kind, dtype.str) or len(shape) != field.dimensions:
            raise _DamagedError(
                f"the array has the type {dtype.str} and the shape {shape}, expected {wanted} "
                f"with {field.dimensions} dimension{'' if field.dimensions == 1 else 's'}"
            )
        if stream.tell() + prod(shape) * dtype.itemsize != info.file_size:
            raise _DamagedError(
                f"the array can't be read: the shape {shape} doesn't fit its {info.file_size} bytes"
            )
    with archive.open(info) as stream:
        array: Array = npy.read_array(stream, allow_pickle=False)
        stream.read()  # at the end the checksum is compared
    if field.finite and not np.isfinite(array).all():
        raise _DamagedError("a number is not finite")
    return array


def digest_of(arrays: Mapping[str, Array]) -> npt.NDArray[np.uint8]:
    """Return the SHA-256 over names, types, shapes and content, in any order of the arrays."""
    digest = hashlib.sha256()
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        digest.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
        digest.update(array.tobytes())
    return np.frombuffer(digest.digest(), dtype=np.uint8)
