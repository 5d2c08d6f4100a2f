from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.cluster.hierarchy import linkage
from scipy.spatial.distance import pdist

from g3.actions.arrangements import _spanning_tree

POINTS = arrays(float, st.tuples(st.integers(2, 12), st.just(2)), elements=st.floats(-50, 50))


@given(POINTS)
def test_links_are_as_long_as_those_of_single_linkage(middles):
    lengths = [length for length, *_ in _spanning_tree(middles)]
    assert np.allclose(lengths, linkage(pdist(middles), "single")[:, 2])
