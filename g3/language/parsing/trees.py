"""Trees that were extracted from commands, with their probabilities."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from g3 import html_view
from g3.data_frames import data_frame
from g3.errors import ModelError
from g3.sdc import sdc_drawing
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import format_brackets
from g3.short_repr import short_repr

if TYPE_CHECKING:
    import pandas as pd


class Tree(NamedTuple):
    """One way to read a command.

    Parameters
    ----------
    sdcs
        The top-level clauses.
    probability
        How probable the model takes this reading to be.
    """

    sdcs: tuple[SDC, ...]
    probability: float


@short_repr
@dataclass(frozen=True, slots=True)
class Parse:
    """Trees extracted from a command.

    Parameters
    ----------
    text
        The command.
    trees
        The most probable trees, the best first; empty if there are none.
    note
        Why there is no tree, or what isn't in it; empty if all went well.
    """

    text: str
    trees: tuple[Tree, ...]
    note: str = ""

    @property
    def sdcs(self) -> tuple[SDC, ...]:
        """The clauses of the best tree."""
        return self.trees[0].sdcs if self.trees else ()

    def __len__(self) -> int:
        """Return the number of trees."""
        return len(self.trees)

    def __iter__(self) -> Iterator[Tree]:
        """The trees, the best first."""
        return iter(self.trees)

    def __getitem__(self, which: int) -> Tree:
        """A tree by its rank, from 0."""
        return self.trees[which]

    def to_pandas(self) -> pd.DataFrame:
        """A row for each tree: its probability, and its clauses in brackets."""
        return data_frame(
            {"probability": p, "clauses": " ".join(format_brackets(sdcs).split())}
            for sdcs, p in self.trees
        )

    def _repr_html_(self) -> str:
        """The command with its trees drawn, the best first."""
        drawn = [
            html_view.paragraph(f"probability {tree.probability:.2f}")
            + sdc_drawing.to_svg(tree.sdcs)
            for tree in self.trees
        ]
        return "\n".join([html_view.heading(self.text, self.note), *drawn])


def with_trees(X: Sequence[Any], y: Sequence[tuple[SDC, ...]] | None) -> Sequence[Any]:
    """Return commands with their trees; ModelError for texts without."""
    if isinstance(X, str):
        raise ModelError("X is one command", fix="give a list of commands, and their trees as y")
    if y is None:
        if any(isinstance(one, str) for one in X):
            raise ModelError(
                "the commands have no trees to learn from", fix="give these as y: fit(texts, trees)"
            )
        return X
    if len(X) != len(y):
        raise ModelError(
            f"there are {len(X)} commands and {len(y)} trees", fix="give a tree for each command"
        )
    return list(zip(X, y, strict=True))
