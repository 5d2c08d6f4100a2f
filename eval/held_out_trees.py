"""SDC trees of commands, extracted by what has learned from no command of their scenario."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence

from corpus_tools.corpus.model import Corpus
from corpus_tools.trees import annotated_trees
from g3.language.extractor import Extractor
from g3.language.extractor_training import prepare, train_extractor


def extractor_learner(corpora: Sequence[Corpus]) -> Callable[[str], Extractor]:
    """What learns to extract trees from all scenarios but the one with a name.

    The extractor that comes along has learned from the bundled corpus and from the paper's, so
    that it must not be asked where commands of these are tested. As with ``ct train sdc`` the
    first corpus says how trees are made, and the others teach as far as they agree. The last
    extractor is kept, for scenarios in a row.
    """
    trees = [annotated_trees(corpus) for corpus in corpora]
    lessons = functools.cache(
        lambda: [prepare([(item.command.text, item.sdcs) for item in part]) for part in trees]
    )
    known = {item.command.scenario for part in trees for item in part}

    @functools.lru_cache(maxsize=1)
    def learned(left_out: str) -> Extractor:
        parts = (
            [
                lesson
                for item, lesson in zip(items, prepared, strict=True)
                if item.command.scenario != left_out
            ]
            for items, prepared in zip(trees, lessons(), strict=True)
        )
        own, *others = [part for part in parts if part] or [[]]
        card = {"scenarios": sorted(known - {left_out})}
        besides = [lesson for part in others for lesson in part]
        return train_extractor(own, others=besides, card=card)

    return lambda scenario: learned(scenario if scenario in known else "")
