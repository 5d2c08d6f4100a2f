"""Files of curves: what is written is read, also in parts, and damage is named."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from safetensors.numpy import load_file

import annotation_app
from corpus_tools.tables.curve_file import (
    FEWEST,
    HEAD_BYTES,
    MOST_CURVES,
    STEP,
    Curve,
    read_header,
    write_curves,
)
from g3.errors import FormatError


def curves(count: int) -> list[Curve]:
    return [Curve("state", f"joint {n}") for n in range(count)]


@settings(max_examples=30)
@given(
    samples=st.integers(1, 3000), count=st.integers(1, 5), piece=st.integers(1, 1000),
    gaps=st.booleans(),
)  # fmt: skip
def test_all_levels_have_the_least_and_greatest(
    tmp_path_factory, samples: int, count: int, piece: int, gaps: bool
):
    file = tmp_path_factory.mktemp("curves") / "a.safetensors"
    rng = np.random.default_rng(samples)
    values = rng.normal(size=(samples, count)).astype(np.float32)
    if gaps:
        values[rng.random(values.shape) < 0.3] = np.nan
    pieces = (values[first : first + piece] for first in range(0, samples, piece))
    write_curves(file, curves(count), 50, samples, pieces)
    header = read_header(file)
    assert (header.rate, header.samples, list(header.curves)) == (50, samples, curves(count))
    levels = load_file(file)  # others' programs read it, too
    np.testing.assert_array_equal(levels["0"], values)
    assert len(levels[str(len(levels) - 1)]) <= FEWEST
    for level in range(1, len(levels)):
        size = STEP**level
        for row, (low, high) in enumerate(zip(*levels[str(level)].transpose(2, 0, 1), strict=True)):
            part = values[row * size : (row + 1) * size]
            np.testing.assert_array_equal(low, np.fmin.reduce(part))
            np.testing.assert_array_equal(high, np.fmax.reduce(part))


def test_missing_and_infinite_numbers_are_gaps(tmp_path: Path):
    file = tmp_path / "a.safetensors"
    write_curves(file, curves(1), 10, 4, [np.array([[1.0], [np.inf]], np.float32)])
    np.testing.assert_array_equal(load_file(file)["0"][:, 0], [1, np.nan, np.nan, np.nan])


@pytest.mark.parametrize("sign", ["a", "𝄞", "\0"])
def test_long_names_fit_into_what_the_page_reads_at_once(tmp_path: Path, sign: str):
    file = tmp_path / "a.safetensors"
    named = [Curve(sign * 100, f"{n} {sign * 90}") for n in range(MOST_CURVES)]
    write_curves(file, named, 10, 1, [np.zeros((1, MOST_CURVES), np.float32)])
    (length,) = struct.unpack("<Q", file.read_bytes()[:8])
    assert 8 + length <= HEAD_BYTES
    names = [curve.name for curve in read_header(file).curves]
    assert [int(name.split()[0]) for name in names] == list(range(MOST_CURVES))
    script = Path(annotation_app.__file__).parent / "static/js/curve-file.js"
    assert f"HEAD_BYTES = 1 << {HEAD_BYTES.bit_length() - 1};" in script.read_text()


def test_damage_is_named(tmp_path: Path):
    file = tmp_path / "a.safetensors"
    write_curves(file, curves(2), 10, 600, [np.zeros((600, 2), np.float32)])
    whole = file.read_bytes()
    changed = [
        b"", whole[:7], whole[:100], whole[:-1], whole + b"x", b"\xff" * 8 + whole[8:],
        whole.replace(b"curves-1", b"curves-9"), whole.replace(b"[600,2]", b"[900,2]"),
        whole.replace(b'"10.0"', b'"-1.0"'), whole.replace(b"F32", b"F64"), b"root:x:0:0:root",
    ]  # fmt: skip
    for content in changed:
        assert content != whole
        file.write_bytes(content)
        with pytest.raises(FormatError, match="no whole file of curves") as error:
            read_header(file)
        assert error.value.where == str(file)
    with pytest.raises(FormatError):
        read_header(tmp_path)


@pytest.mark.parametrize("samples", [0, -5])
def test_a_file_has_samples(tmp_path: Path, samples: int):
    """The header fits the size of the file, and yet there is nothing to draw."""
    size = 4 * samples
    names = json.dumps([{"group": "state", "name": "joint"}])
    header = {
        "__metadata__": {"kind": "curves-1", "rate": "10.0", "curves": names},
        "0": {"dtype": "F32", "shape": [samples, 1], "data_offsets": [0, size]},
    }
    content = json.dumps(header).encode()
    file = tmp_path / "a.safetensors"
    file.write_bytes(struct.pack("<Q", len(content) - size) + content)
    with pytest.raises(FormatError, match="no whole file of curves"):
        read_header(file)
