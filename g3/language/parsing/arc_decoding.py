"""Trees of a command from the probabilities of its words' arcs.

In annotated trees hardly any arcs cross: a few in a thousand. A command that says the same word
twice is read much better if arcs may not cross. The most probable set of such arcs is found by
dynamic programming (Eisner, 1996). Arcs from the root don't count: a comma or an aside may stand
within a clause.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from itertools import count

import numpy as np
import numpy.typing as npt

from g3.language.parsing.arc_model import Float32Array
from g3.language.parsing.clause_arcs import INSIDE, OUTSIDE, ROOT, Arcs

LEAST_SHARE = 1e-4
"""An arc with a smaller share of its word's probability is in no tree but the best."""
MOST_CHOICES = 500
"""Trees that are looked at, at most, for the most probable ones."""
_IMPOSSIBLE = np.float32(-1e9)


def likely_arcs(
    scores: Float32Array, labels: Sequence[str], least: float = LEAST_SHARE
) -> Iterator[tuple[float, Arcs]]:
    """Yield sets of arcs that make trees with their probabilities, the most probable first.

    In a tree, words hang from anchors only, in no circle, and arcs don't cross.

    Parameters
    ----------
    scores
        Log probabilities of :func:`log_probabilities`.
    labels
        The labels.
    least
        Smallest share of a word's probability of an arc that is tried.
    """
    n = len(scores)
    options = [_options(row, least) for row in scores]
    anchors = np.array([label not in (OUTSIDE, INSIDE) for label in labels])
    order = count()
    best = [option[0][1:] for option in options]
    if not _is_tree(best, anchors):
        best = _best_tree(scores, labels)
        for i, arc in enumerate(best):
            chance = float(scores[i][arc])
            rest = [one for one in options[i] if one[0] <= chance and one[1:] != arc]
            options[i] = [(chance, *arc), *rest]
    total = sum(option[0][0] for option in options)
    heap = [(-total, next(order), (0,) * n, 0)]
    for _ in range(MOST_CHOICES):
        if not heap:
            return
        negative, _, ranks, first = heapq.heappop(heap)
        chosen = [options[i][rank][1:] for i, rank in enumerate(ranks)]
        if _is_tree(chosen, anchors):
            yield _named(scores, labels, chosen)
        for i in range(first, n):
            if ranks[i] + 1 < len(options[i]):
                further = negative + options[i][ranks[i]][0] - options[i][ranks[i] + 1][0]
                following = (*ranks[:i], ranks[i] + 1, *ranks[i + 1 :])
                heapq.heappush(heap, (further, next(order), following, i))


def _named(
    scores: Float32Array, labels: Sequence[str], arcs: Sequence[tuple[int, int]]
) -> tuple[float, Arcs]:
    """The probability of heads and labels, and the arcs that they are."""
    total = sum(float(scores[i, head, name]) for i, (head, name) in enumerate(arcs))
    heads = tuple([ROOT if head == 0 else head - 1 for head, _ in arcs])
    return min(float(np.exp(total)), 1.0), Arcs(heads, tuple([labels[name] for _, name in arcs]))


def _options(row: Float32Array, least: float) -> list[tuple[float, int, int]]:
    """A word's arcs as (log probability, head, label), the most probable first."""
    flat = row.ravel()
    likely = np.flatnonzero(flat >= np.log(least))
    if not len(likely):
        likely = np.array([flat.argmax()])
    ordered = likely[np.argsort(-flat[likely], kind="stable")]
    size = row.shape[1]
    return [(float(flat[i]), *divmod(int(i), size)) for i in ordered]


def _is_tree(arcs: Sequence[tuple[int, int]], anchors: npt.NDArray[np.bool_]) -> bool:
    """Return True if words hang from anchors only, in no circle, and arcs don't cross."""
    heads = [head for head, _ in arcs]
    if not all(head == 0 or anchors[arcs[head - 1][1]] for head in heads):
        return False
    done = [True] + [False] * len(heads)
    for first in range(1, len(done)):
        path, word = [], first
        while not done[word]:
            done[word] = True
            path.append(word)
            word = heads[word - 1]
        if word in path:
            return False
    return not _cross(heads)


def _cross(heads: Sequence[int]) -> bool:
    """Return True if two arcs cross, those from the root aside."""
    ends = sorted((min(i, h), -max(i, h)) for i, h in enumerate(heads, start=1) if h)
    around: list[int] = []
    for start, end in ends:
        while around and around[-1] <= start:
            around.pop()
        if around and -end > around[-1]:
            return True
        around.append(-end)
    return False


def _best_tree(scores: Float32Array, labels: Sequence[str]) -> list[tuple[int, int]]:
    """Return the most probable heads and labels whose arcs make a tree.

    A clause whose own verb hangs from the root is not looked for around that verb.

    Parts of the command are put together from short to long ones. They are known by their length
    and their first or last word: in `right` a word and those after it that hang from it, in `left`
    a word and those before it; each is held by its start and by its end. In `open_right` and
    `open_left` the last or the first word hangs from the other end, and may get further words.
    """
    n = len(scores) + 1
    leaf, at_leaf = _of_leaves(scores, labels)
    anchor, at_anchor = _of_anchors(scores, labels)
    shape = (n, n)
    right, right_by_end, left, left_by_start, open_right, open_left = (
        np.full(shape, _IMPOSSIBLE, dtype=np.float32) for _ in range(6)
    )
    for part in (right, right_by_end, left, left_by_start):
        part[:, 0] = 0
    splits, rights, lefts = (np.zeros(shape, dtype=np.intp) for _ in range(3))
    for w in range(1, n):
        starts, ends = np.arange(n - w), np.arange(w, n)
        inner = right[:-w, :w] + left[w:, w - 1 :: -1]
        splits[starts, w] = inner.argmax(axis=1)
        best = inner.max(axis=1)
        open_right[starts, w] = best + anchor[ends, starts]
        open_left[ends, w] = best + anchor[starts, ends]
        # the last column stands for a word that nothing hangs from
        longer = open_right[:-w, 1 : w + 1] + right_by_end[w:, w - 1 :: -1]
        as_leaf = right[starts, w - 1] + leaf[ends, starts]
        longer = np.column_stack([longer, as_leaf])
        rights[starts, w] = longer.argmax(axis=1)
        right[starts, w] = right_by_end[ends, w] = longer.max(axis=1)
        longer = open_left[w:, 1 : w + 1] + left_by_start[:-w, w - 1 :: -1]
        as_leaf = left[ends, w - 1] + leaf[starts, ends]
        longer = np.column_stack([longer, as_leaf])
        lefts[starts, w] = longer.argmax(axis=1)
        left[ends, w] = left_by_start[starts, w] = longer.max(axis=1)
    result = [(0, 0)] * n
    waiting = [("right", 0, n - 1)]
    while waiting:
        kind, start, end = waiting.pop()
        w = end - start
        if not w:
            continue
        if kind == "right":
            k = int(rights[start, w]) + 1
            if k > w:
                result[end] = divmod(int(at_leaf[end, start]), len(labels))
                waiting.append(("right", start, end - 1))
            else:
                waiting += [("open right", start, start + k), ("right", start + k, end)]
        elif kind == "left":
            k = int(lefts[start, w]) + 1
            if k > w:
                result[start] = divmod(int(at_leaf[start, end]), len(labels))
                waiting.append(("left", start + 1, end))
            else:
                waiting += [("open left", end - k, end), ("left", start, end - k)]
        else:
            word, head = (end, start) if kind == "open right" else (start, end)
            result[word] = divmod(int(at_anchor[word, head]), len(labels))
            middle = start + int(splits[start, w])
            waiting += [("right", start, middle), ("left", middle + 1, end)]
    return result[1:]


def _of_leaves(
    scores: Float32Array, labels: Sequence[str]
) -> tuple[Float32Array, npt.NDArray[np.intp]]:
    """Log probabilities (n + 1, n + 1) of words from which nothing hangs, and their arcs."""
    return _chosen(scores, np.array([label in (INSIDE, OUTSIDE) for label in labels]))


def _of_anchors(
    scores: Float32Array, labels: Sequence[str]
) -> tuple[Float32Array, npt.NDArray[np.intp]]:
    return _chosen(scores, np.array([label not in (INSIDE, OUTSIDE) for label in labels]))


def _chosen(
    scores: Float32Array, possible: npt.NDArray[np.bool_]
) -> tuple[Float32Array, npt.NDArray[np.intp]]:
    """The best label of each arc; what hangs from the root may stand below any other word."""
    n, _, count_ = scores.shape
    masked = np.where(possible, scores, _IMPOSSIBLE)
    values = np.full((n + 1, n + 1), _IMPOSSIBLE, dtype=np.float32)
    values[1:] = np.maximum(masked.max(axis=2), _IMPOSSIBLE)
    arcs = np.zeros((n + 1, n + 1), dtype=np.intp)
    arcs[1:] = masked.argmax(axis=2) + np.arange(n + 1) * count_
    from_root = values[:, :1] > values
    return np.where(from_root, values[:, :1], values), np.where(from_root, arcs[:, :1], arcs)
