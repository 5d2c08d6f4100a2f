"""Arrays come back as they were written, and each way to damage them has its message."""

from __future__ import annotations

import io
import zipfile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays_of

from g3.errors import CorpusError, ModelError
from g3.storage.array_file import ALLOWANCE, DIGEST, Field, read_arrays, write_arrays

FIELDS = {"a": Field("<f8", finite=True), "b": Field("<i4", dimensions=2)}
WRITTEN = {"a": np.arange(3.0), "b": np.arange(6, dtype="<i4").reshape(2, 3)}


def read(content, fields=None):
    return read_arrays(content, fields or FIELDS, where="x.npz", fix="again", error=ModelError)


def zipped(**members: bytes) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for name, data in members.items():
            archive.writestr(f"{name}.npy", data)
    return out.getvalue()


def member(array) -> bytes:
    out = io.BytesIO()
    np.lib.format.write_array(out, np.asarray(array))
    return out.getvalue()


@given(
    st.sampled_from(["<f8", "<f2", "<i4", "|u1", "|b1", "<U3"]).flatmap(
        lambda dtype: arrays_of.arrays(
            dtype, arrays_of.array_shapes(min_dims=1, max_dims=3, min_side=0)
        )
    ),
    st.booleans(),
    st.booleans(),
)
def test_arrays_come_back(array, compressed, by_column):
    array = np.asfortranarray(array) if by_column else array
    content = write_arrays({"a": array}, compressed=compressed, sealed=True)
    kind = "U" if array.dtype.kind == "U" else array.dtype.str
    found = read(content, {"a": Field(kind, array.ndim)})
    assert found["a"].tobytes() == array.tobytes()
    assert found["a"].shape == array.shape
    assert found["a"].flags.writeable
    assert DIGEST in found
    assert write_arrays({"a": array}, compressed=compressed, sealed=True) == content


def test_a_file_is_read_where_it_lies(tmp_path):
    (tmp_path / "x.npz").write_bytes(write_arrays(WRITTEN))
    assert np.array_equal(read(tmp_path / "x.npz")["b"], WRITTEN["b"])


A, B = member(WRITTEN["a"]), member(WRITTEN["b"])
DIRECTORY = b"PK\x01\x02"


def in_directory(offset: int, value: bytes) -> bytes:
    """A file with other bytes in the first entry of its directory."""
    content = zipped(a=A, b=B)
    at = content.index(DIRECTORY) + offset
    return content[:at] + value + content[at + len(value) :]


def shaped(text: bytes) -> bytes:
    """A member whose header has another shape, as long as before."""
    spare = len(text) - len(b"(3,)")
    return A.replace(b"(3,)", text).replace(b" " * (spare + 1) + b"\n", b" \n")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "x.npz: the arrays can't be read: File is not a zip file (again)"),
        (zipped(a=A), "x.npz: b: the array is missing (again)"),
        (in_directory(8, b"\1\0"), "x.npz: a: the array can't be read: File <ZipInfo"),
        (in_directory(10, b"\x63\0"), "x.npz: a: the array can't be read: That compression"),
        (in_directory(16, b"1234"), "x.npz: a: the array can't be read: Bad CRC-32"),
        (zipped(a=shaped(b"(999999999999,)"), b=B), "x.npz: a: the array can't be read: the shape"),
        (zipped(a=A[:-1], b=B), "x.npz: a: the array can't be read: the shape (3,) doesn't fit"),
        (zipped(a=A + b"x", b=B), "x.npz: a: the array can't be read: the shape (3,) doesn't fit"),
        (
            zipped(a=A.replace(b"'descr'", b"'descr("), b=B),
            "x.npz: a: the array can't be read: Cannot parse header",
        ),
        (zipped(a=b"", b=B), "x.npz: a: the array can't be read: EOF"),
        (zipped(a=A.replace(b"<f8", b"|O8"), b=B), "x.npz: a: the array has the type |O and"),
        (zipped(a=A.replace(b"<f8", b"<i8"), b=B), "x.npz: a: the array has the type <i8 and the"),
        (zipped(a=A.replace(b"<f8", b">f8"), b=B), "x.npz: a: the array has the type >f8"),
        (zipped(a=B, b=B), "x.npz: a: the array has the type <i4 and the shape (2, 3), expected"),
        (zipped(a=member([np.nan]), b=B), "x.npz: a: a number is not finite"),
        (zipped(a=A, b=B, digest=A), "x.npz: digest: the array has the type <f8"),
    ],
)
def test_damage_is_named(content, message):
    with pytest.raises(ModelError) as caught:
        read(content)
    assert str(caught.value).startswith(message)


def test_arrays_that_changed_places_do_not_have_their_digest():
    fields = {"a": Field("<f8"), "b": Field("<f8")}
    one, other = np.arange(3.0), np.arange(3.0) + 1
    seal = read(write_arrays({"a": one, "b": other}, sealed=True), fields)[DIGEST]
    swapped = zipped(a=member(other), b=member(one), digest=member(seal))
    with pytest.raises(ModelError, match="digest: the arrays are not those that were written"):
        read(swapped, fields)


def test_a_file_can_not_make_itself_larger_than_the_memory():
    content = write_arrays({"a": np.zeros(4 * ALLOWANCE, dtype=np.uint8)})
    with pytest.raises(ModelError, match=r"a: the array can't be read: it promises \d+ bytes, in"):
        read(content, {"a": Field("|u1")})
    allowed = write_arrays({"a": np.zeros(ALLOWANCE // 2, dtype=np.uint8)})
    assert len(read(allowed, {"a": Field("|u1")})["a"]) == ALLOWANCE // 2


@given(st.binary(max_size=200), st.integers(0, 400))
def test_any_bytes_are_read_or_refused(rubbish, at):
    content = write_arrays(WRITTEN)
    for damaged in (rubbish, b"PK\x03\x04" + rubbish, content[:at] + rubbish + content[at:]):
        try:
            found = read(damaged)
        except CorpusError as error:
            assert "x.npz" in str(error)  # noqa: PT017 - most are refused, not all
        else:
            assert np.array_equal(found["a"], WRITTEN["a"])
