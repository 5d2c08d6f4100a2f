"""The encoder: pieces of words, vectors in context, and its file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from g3.errors import ModelError
from g3.language.parsing import encoder as encoding
from g3.language.parsing.encoder import (
    MATRICES,
    Encoder,
    default_encoder,
    from_bytes,
    layer_arrays,
    to_bytes,
    with_last_layers,
)
from g3.language.parsing.words import MAX_WORDS, cut

PIECES = ("[UNK]", "[CLS]", "[SEP]", "un", "##load", "##ed", "lift", "it", "'", "t", "don")
WIDTH = 24


def small(seed=0):
    """Bytes of an encoder with small vectors and two layers."""
    rng = np.random.default_rng(seed)

    def random(*shape):
        return rng.standard_normal(shape) / 4

    sizes = dict.fromkeys(MATRICES, (WIDTH, WIDTH))
    sizes |= {"inner": (2 * WIDTH, WIDTH), "outer": (WIDTH, 2 * WIDTH)}
    layers = [
        {name: (random(*size), random(size[0])) for name, size in sizes.items()} for _ in range(2)
    ]
    return to_bytes(
        PIECES, random(len(PIECES), WIDTH), random(12, WIDTH), random(10, WIDTH), layers
    )


@pytest.mark.parametrize(
    ("form", "pieces"),
    [
        ("lift", ["lift"]),
        ("unloaded", ["un", "##load", "##ed"]),
        ("don't", ["don", "'", "t"]),
        ("unlift", ["[UNK]"]),
        ("ìt", ["it"]),
        ("😀", ["[UNK]"]),
    ],
)
def test_words_are_cut_into_the_longest_pieces(form, pieces):
    encoder = from_bytes(small())
    assert [encoder.vocabulary[i] for i in encoder.pieces(form)] == pieces


@settings(deadline=None, max_examples=25)
@given(st.lists(st.sampled_from(["lift it", "", "unloaded it don't", "it", "x " * 30]), max_size=5))
def test_each_command_is_encoded_by_itself(texts):
    encoder = from_bytes(small())
    commands = [cut(text) for text in texts]
    together = list(encoder.encode_all(commands))
    assert [len(vectors) for vectors in together] == [len(command.forms) for command in commands]
    for vectors, command in zip(together, commands, strict=True):
        (alone,) = encoder.encode_all([command])
        assert np.allclose(vectors, alone, atol=1e-5)
        assert np.isfinite(vectors).all()


def test_encoders_share_what_they_have_in_common():
    encoder, command = default_encoder(), cut("put both crates on it")
    own = with_last_layers(encoder, layer_arrays(encoder.layers[-2:], encoder.norms[-8:] * 1.1))
    (vectors,), (others,) = encoder.encode_all([command]), own.encode_all([command])
    (alone,) = replace(own, recent={}).encode_all([command])
    assert np.allclose(others, alone, atol=1e-5)
    assert not np.allclose(others, vectors, atol=1e-2)


def test_a_word_has_another_vector_in_another_place():
    encoder = from_bytes(small())
    one, other = encoder.encode_all([cut("lift it"), cut("it lift")])
    assert not np.allclose(one[0], other[1], atol=1e-3)


def test_a_file_holds_the_weights_to_a_hundredth():
    rng = np.random.default_rng(3)
    matrix = rng.standard_normal((5, 7))
    integers, scales = encoding.quantised(matrix)
    assert integers.dtype == np.int8
    assert np.abs(integers * scales[:, None] - matrix).max() <= 0.01 * np.abs(matrix).max()
    assert small() == small()
    assert from_bytes(small()).digest != from_bytes(small(1)).digest


@pytest.mark.parametrize("at", [0.1, 0.5, 0.9])
def test_damage_is_told(at):
    content = bytearray(small())
    content[int(at * len(content))] ^= 0xFF
    with pytest.raises(ModelError, match=r"enc: .*install the package again"):
        from_bytes(bytes(content), where="enc")


def test_the_one_that_comes_along_is_small_and_knows_english():
    encoder: Encoder = default_encoder()
    pieces = [encoder.vocabulary[i] for i in encoder.pieces("forklift")]
    assert "".join(piece.removeprefix("##") for piece in pieces) == "forklift"
    assert sum(layer[name][0].size for layer in encoder.layers for name in MATRICES) < 12e6


def test_a_long_text_is_encoded_as_far_as_there_are_places():
    (vectors,) = default_encoder().encode_all([cut("lift it " * MAX_WORDS)])
    assert len(vectors) == MAX_WORDS
    assert np.abs(vectors[:100]).sum(axis=1).all()
