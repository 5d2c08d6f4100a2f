"""Commands followed with each potential, and each feature set, switched off in turn.

Learned costs don't depend on potentials. So they are learned once for each scenario that is held
out, and its commands are followed with each potential off. A feature set needs costs of its own.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.parallel import Done, Workers
from corpus_tools.runtime.progress import OnProgress, no_progress
from eval.table_3.following import follow_command
from eval.table_3.held_out import costs_without, extractor_without
from eval.table_3.judged_commands import JudgedCommand, judged_commands
from eval.table_3.outcomes import Outcome
from eval.table_3.search_examples import read_or_made, shared
from g3.errors import CorpusError, ModelError
from g3.inference.grounder import Grounder
from g3.inference.potentials.potential_registry import check_potentials, heard, potentials
from g3.inference.problem.costs import Scorer
from g3.inference.training import search_sets
from g3.language.parsing.extractor import SDCExtractor
from g3.sdc.clauses import SDC

Clauses = Literal["gold", "auto"]
NOTHING = ""
"""The name of the run with nothing switched off."""
Followed = Mapping[str, Sequence[Outcome]]
OnPart = Callable[[str, Followed], None]


@dataclass(frozen=True, slots=True)
class Ablations:
    """What is switched off in turn, and on which commands.

    Parameters
    ----------
    train, test
        Names of the corpora to learn from, and of those whose commands are followed.
    clauses
        ``gold`` takes annotated clauses where there are some, ``auto`` always extracted ones.
    most
        How many commands of each scenario to follow; 0 for all.
    """

    train: tuple[str, ...]
    test: tuple[str, ...]
    potentials: tuple[str, ...] = ()
    feature_sets: tuple[str, ...] = ()
    clauses: Clauses = "gold"
    l2: float = 1.0
    seed: int = 0
    most: int = 0

    @property
    def candidates(self) -> tuple[tuple[str, str], ...]:
        """The name and the kind of all that is switched off."""
        return (
            *((name, "potential") for name in self.potentials),
            *((name, "feature set") for name in self.feature_sets),
        )


def on_trial(
    potential_names: Sequence[str], set_names: Sequence[str], *, all_sets: bool = False
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What to switch off: potentials and feature sets; all potentials if nothing is named."""
    used = [own.name for own in search_sets()]
    strange = next((name for name in set_names if name not in used), None)
    if strange is not None:
        raise ModelError(
            f"models use no feature set {strange!r}",
            fix=f"take some of these: {', '.join(used)}",
        )
    check_potentials(potential_names)
    named = tuple(dict.fromkeys(potential_names))
    sets = tuple(used) if all_sets else tuple(dict.fromkeys(set_names))
    return named or (() if set_names else tuple(p.name for p in potentials())), sets


@dataclass(frozen=True, slots=True)
class _Part:
    """A scenario's commands, followed with costs without a feature set; with all if it's empty."""

    without: str
    corpus: str
    scenario: str

    @property
    def key(self) -> str:
        return " | ".join((self.without, self.corpus, self.scenario))


def run(
    asked: Ablations,
    *,
    done: Mapping[str, Followed] = MappingProxyType({}),
    on_part: OnPart | None = None,
    workers: Workers | None = None,
    on_progress: OnProgress = no_progress,
) -> dict[str, dict[str, list[Outcome]]]:
    """The outcomes with nothing switched off, and of each candidate those that it may change.

    Parameters
    ----------
    done
        What is done already, as `on_part` got it.
    on_part
        Called with each scenario that is done now: a key, and its outcomes by what is switched off.

    Returns
    -------
    dict
        By corpus and by what is switched off; `NOTHING` has all commands.

    Raises
    ------
    CorpusError
        If that fails for a scenario, after all others are done.
    """
    scenarios = {
        name: sorted({t.command.scenario for t in judged_commands(open_corpus(name), asked.most)})
        for name in asked.test
    }
    rounds = (NOTHING, *asked.feature_sets)
    parts = {
        without: [_Part(without, name, s) for name, own in scenarios.items() for s in own]
        for without in rounds
    }
    total = sum(map(len, parts.values()))
    found = {p.key: done[p.key] for own in parts.values() for p in own if p.key in done}
    failed: list[Done[_Part, dict[str, list[Outcome]]]] = []
    for without in rounds:
        left = [part for part in parts[without] if part.key not in found]
        for item in _followed(asked, without, left, workers or Workers(), on_progress):
            if item.result is None:
                failed.append(item)
                continue
            found[item.item.key] = item.result
            if on_part:
                on_part(item.item.key, item.result)
            on_progress("following commands, by scenario", len(found), total)
    if failed:
        first = failed[0].error
        raise CorpusError(
            f"commands of {len(failed)} scenarios can't be followed: "
            f"{', '.join(dict.fromkeys(f.item.scenario for f in failed))}",
            where=failed[0].item.corpus,
            fix=f"the first says {type(first).__name__}: {first}",
        ) from first
    together: dict[str, dict[str, list[Outcome]]] = {name: {} for name in asked.test}
    for part in (p for own in parts.values() for p in own):
        for off, outcomes in found[part.key].items():
            together[part.corpus].setdefault(off, []).extend(outcomes)
    return together


def _followed(
    asked: Ablations,
    without: str,
    parts: Sequence[_Part],
    workers: Workers,
    on_progress: OnProgress,
) -> Iterator[Done[_Part, dict[str, list[Outcome]]]]:
    """What comes of each part; the workers make what they learn from together."""
    if not parts:
        return
    known = [open_corpus(name) for name in asked.train]
    sets = search_sets({without} - {NOTHING})
    made = shared(known, sets, seed=asked.seed, workers=workers, on_progress=on_progress)
    with made as (executor, file):
        try:
            yield from executor.work(functools.partial(_follow, asked=asked, file=file), parts)
        finally:
            _lessons.cache_clear()
            _tested.cache_clear()


@dataclass(frozen=True, slots=True, eq=False)
class _Lessons:
    """What a process has made ready to learn from."""

    cost_of: Callable[[str], Scorer]
    extractor_of: Callable[[str], SDCExtractor]


@functools.lru_cache(maxsize=1)
def _lessons(asked: Ablations, without: str, file: Path) -> _Lessons:
    known = [open_corpus(name) for name in asked.train]
    data = read_or_made(file, known, search_sets({without} - {NOTHING}), seed=asked.seed)
    choices = load_choices_of(known)
    return _Lessons(costs_without(data, choices, l2=asked.l2), extractor_without(known))


@functools.lru_cache(maxsize=1)
def _tested(corpus: str, most: int) -> Sequence[JudgedCommand]:
    return judged_commands(open_corpus(corpus), most)


def _follow(part: _Part, *, asked: Ablations, file: Path) -> dict[str, list[Outcome]]:
    """The outcomes of a scenario's commands by what is switched off."""
    lessons = _lessons(asked, part.without, file)
    cost = lessons.cost_of(part.scenario)
    own = [t for t in _tested(part.corpus, asked.most) if t.command.scenario == part.scenario]
    if asked.clauses == "auto":
        own = [replace(t, annotation=None) for t in own]
    texts = [t.command.text for t in own if not t.annotation]
    trees = iter(lessons.extractor_of(part.scenario).predict(texts) if texts else ())
    extracted = [() if t.annotation else next(trees) for t in own]
    if part.without:
        return {part.without: [_one(t, s, cost) for t, s in zip(own, extracted, strict=True)]}
    outcomes: dict[str, list[Outcome]] = {NOTHING: []}
    for tested, sdcs in zip(own, extracted, strict=True):
        with heard() as said:
            outcomes[NOTHING].append(_one(tested, sdcs, cost))
        for name in asked.potentials:
            if name in said:
                outcomes.setdefault(name, []).append(_one(tested, sdcs, cost, off=name))
    return outcomes


def _one(tested: JudgedCommand, sdcs: Sequence[SDC], cost: Scorer, *, off: str = "") -> Outcome:
    grounder = Grounder(cost, without=(off,) if off else ())
    return follow_command("gold" if tested.annotation else "auto", tested, sdcs, grounder)
