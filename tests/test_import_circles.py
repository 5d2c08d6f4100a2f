"""No two modules need each other, not even in a function or for a type."""

import numpy as np
import pytest
from scipy.sparse import lil_matrix
from scipy.sparse.csgraph import connected_components

grimp = pytest.importorskip("grimp")

PACKAGES = ("g3", "corpus_tools", "eval", "annotation_app", "ct")


def circles() -> list[set[str]]:
    """Modules that reach each other by imports; a package's own module doesn't count."""
    graph = grimp.build_graph(*PACKAGES)
    names = sorted(m for m in graph.modules if not graph.find_children(m))
    place = {name: i for i, name in enumerate(names)}
    imports = lil_matrix((len(names), len(names)), dtype=bool)
    for name in names:
        for other in graph.find_modules_directly_imported_by(name) & place.keys():
            imports[place[name], place[other]] = True
    count, of = connected_components(imports, connection="strong")
    assert count > 300  # it has looked
    sizes = np.bincount(of)
    return [{n for n in names if of[place[n]] == i} for i in np.flatnonzero(sizes > 1)]


def test_imports_have_no_circles():
    assert circles() == []
