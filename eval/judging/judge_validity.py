"""Agreement of the automatic judge with people on commands and videos.

People have judged commands with the videos that they were typed for, and with others. Each of the
judge's two verdicts is made on the same pairs. *Ends where the log ends*
(:mod:`eval.judging.judge`) compares the log of the shown video with that of the command's own.
*Does what the words say* (:mod:`eval.judging.words_judge`) evaluates the shown log in its own
world, as people did.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.estimate import Estimate, Reason, undefined
from corpus_tools.runtime.parallel import Executor
from corpus_tools.simulation.simulated_raters import STUDY as SIMULATED
from eval.judging.execution import logged, replayed
from eval.judging.judge import Verdict, judge
from eval.judging.judge_registry import JudgedPlan, PlanJudge
from eval.judging.words_judge import judge_by_words
from eval.statistics.estimates import (
    BoolArray,
    FloatArray,
    IntArray,
    percentiles,
    ratio,
    resampled_sums,
)
from eval.statistics.ratings import AGREES, check_judgments, codes, of_study, shown_pair
from g3.annotation import RATINGS, Annotation, Judgment
from g3.errors import FormatError
from g3.groundings import Context
from g3.short_repr import short_repr

ABSENT = "it moves something that the command's world doesn't have"
ENDS, WORDS = "ends_where_log_ends", "does_what_words_say"
VERDICTS = {ENDS: "ends where the log ends", WORDS: "does what the words say"}
"""The judge's verdicts, by their names in JSON."""
CHOSEN_ON = frozenset(
    {
        "go_to_receiving",
        "move_box_pallet",
        "move_box_pallet_to_storage_e",
        "move_tire_pallet1",
        "pickup_tire_pallet1",
        "put_box_pallet_on_trailer",
        "put_tire_pallet_in_storage1",
        "put_tire_pallet_on_trailer1",
    }
)
"""Scenarios of the paper's corpus on which the rules of the second verdict were chosen: every
other one of its 15 in the order of their names. All others are its test."""


@short_repr
@dataclass(frozen=True, slots=True)
class JudgedPair:
    """A command with a video, as people and the judge see it."""

    command: str
    command_video: str
    shown_video: str
    """The words, the video that they were typed for, and the shown video."""
    scenario: str
    """The scenario that the command was typed for."""
    ratings: tuple[int, ...]
    """People's ratings, from 1 to 5, ascending."""
    people: bool
    """True if more than half of the people agree."""
    verdicts: Mapping[str, Verdict]
    """The judge's verdicts, by name; without the second one where it can't judge."""

    @property
    def original(self) -> bool:
        """True if the video is the command's own."""
        return self.command_video == self.shown_video


@short_repr
@dataclass(frozen=True, slots=True)
class Validity:
    """Agreement of the judge with the majority of people."""

    pairs: tuple[JudgedPair, ...]
    left_out: int
    """Number of rated pairs that are left out, as a video has no log here."""
    study: str
    near_misses: Mapping[str, Mapping[str, Agreement]]
    """By verdict, the agreement on pairs with another video than the command's own: on ``all``, on
    those of the scenarios that the second verdict's rules were ``chosen_on``, and on ``others``."""
    own_videos: Mapping[str, Agreement]
    """By verdict, the agreement on pairs with the command's own video."""
    together: Agreement
    """The first verdict's agreement on all pairs."""
    auc: Estimate
    """Probability that a pair that the first verdict accepts has a higher mean rating than one that
    it rejects; ties count half. The judge itself has no degrees."""
    titles: Mapping[str, str] = field(default_factory=lambda: VERDICTS)
    """Titles of the verdicts, by their names in JSON."""

    @property
    def disagreements(self) -> tuple[JudgedPair, ...]:
        """Pairs with a verdict that differs from most people's."""
        return tuple(
            p for p in self.pairs if any(v.correct != p.people for v in p.verdicts.values())
        )


def judge_validity(
    corpus: Corpus,
    *,
    seed: int,
    draws: int,
    study: str = "",
    other: PlanJudge | None = None,
    executor: Executor | None = None,
) -> Validity:
    """Compare the judge with the people whose judgments a corpus holds.

    `other` is a further judge to compare with people. `executor` makes the resamples
    (:func:`eval.statistics.estimates.resampled_sums`).
    """
    if not corpus.judgments:
        raise FormatError(
            "the corpus has no judgments",
            fix="give one with ratings of videos",
        )
    check_judgments(corpus.judgments, {command.video for command in corpus.commands.values()})
    mine = of_study(corpus.judgments, study)
    pairs, left_out = _judged(mine, corpus, other)
    titles = {**VERDICTS, **({other.name: f"the judge {other.name}"} if other else {})}
    if not pairs:
        raise FormatError(
            "no judged pair has the logs of both videos", fix="give a corpus that has their logs"
        )

    def resampled(counts: FloatArray) -> FloatArray:
        # The same seed for each figure, so that all are of the same videos.
        return resampled_sums(
            counts, rng=np.random.default_rng(seed), draws=draws, executor=executor
        )

    others = [p for p in pairs if not p.original]
    halves = {
        "all": others,
        "chosen_on": [p for p in others if p.scenario in CHOSEN_ON],
        "others": [p for p in others if p.scenario not in CHOSEN_ON],
    }
    own_videos = [p for p in pairs if p.original]
    return Validity(
        tuple(pairs),
        left_out,
        mine[0].study,
        {v: {name: _agree(some, v, resampled) for name, some in halves.items()} for v in titles},
        {v: _agree(own_videos, v, resampled) for v in titles},
        _agree(pairs, ENDS, resampled),
        _auc_of(pairs, resampled),
        titles,
    )


def known_validity(corpora: Iterable[Corpus], *, seed: int, draws: int) -> Validity | None:
    """Return the judge's validity on the first corpus with people's ratings; None if none has."""
    for corpus in corpora:
        contexts = contexts_of_videos(corpus)
        rated = [j for j in corpus.judgments if j.study != SIMULATED]
        if any({j.command_video, j.shown_video} <= contexts.keys() for j in rated):
            return judge_validity(replace(corpus, judgments=tuple(rated)), seed=seed, draws=draws)
    return None


def contexts_of_videos(corpus: Corpus) -> dict[str, Context]:
    """Return the world and log of each video that has some; a context's id is also a video's."""
    contexts = {a.command.video: a.context for a in reversed(corpus.annotations)}
    contexts |= corpus.contexts
    # A robot alone, as in a treebank, is no world.
    return {video: context for video, context in contexts.items() if len(context.objects) > 1}


def _annotated(corpus: Corpus) -> dict[tuple[str, str], Annotation]:
    """Return the first positive annotation of each command, by video and text."""
    annotations: dict[tuple[str, str], Annotation] = {}
    for annotation in corpus.annotations:
        if annotation.source == "positive":
            command = annotation.command
            annotations.setdefault((command.video, _plain(command.text)), annotation)
    return annotations


def _plain(text: str) -> str:
    """Return a command with its white space normalised."""
    return " ".join(text.split())


def _judged(
    judgments: Sequence[Judgment], corpus: Corpus, other: PlanJudge | None
) -> tuple[list[JudgedPair], int]:
    contexts, annotations = contexts_of_videos(corpus), _annotated(corpus)
    scenarios = {command.video: command.scenario for command in corpus.commands.values()}
    ratings: dict[tuple[str, str, str], list[int]] = {}
    for j in judgments:
        ratings.setdefault(shown_pair(j), []).append(RATINGS.index(j.rating) + 1)
    with_logs = {key: given for key, given in ratings.items() if {*key[1:]} <= contexts.keys()}
    ends = {
        (own_context, shown): _ends(contexts[own_context], contexts[shown])
        for _, own_context, shown in with_logs
    }
    executions = {video: logged(contexts[video]) for video in {shown for _, _, shown in with_logs}}
    cases = {
        (text, own_context, shown): JudgedPlan(
            text,
            executions[shown],
            (),
            contexts[own_context],
            annotations.get((own_context, _plain(text))),
        )
        for text, own_context, shown in with_logs
    }
    others = _verdicts(cases, other) if other else {}
    pairs = []
    for (text, own_context, shown), given in with_logs.items():
        verdicts = {ENDS: ends[own_context, shown]}
        by_words = judge_by_words(annotations.get((own_context, _plain(text))), executions[shown])
        if by_words is not None:
            verdicts[WORDS] = by_words
        if other:
            verdicts[other.name] = others[text, own_context, shown]
        agree = 2 * sum(r >= AGREES for r in given) > len(given)
        scenario = scenarios.get(own_context, "")
        rated = tuple(sorted(given))
        pairs.append(JudgedPair(text, own_context, shown, scenario, rated, agree, verdicts))
    return pairs, len(ratings) - len(with_logs)


def _verdicts(
    cases: Mapping[tuple[str, str, str], JudgedPlan], other: PlanJudge
) -> dict[tuple[str, str, str], Verdict]:
    """Judge pairs, as many at the same time as the judge allows."""
    with ThreadPoolExecutor(other.at_once) as threads:
        return dict(zip(cases, threads.map(other.verdict, cases.values()), strict=True))


def _ends(own_context: Context, shown: Context) -> Verdict:
    state = replayed(own_context, shown)
    return Verdict(False, ABSENT) if state is None else judge(own_context, state)


def _agree(pairs: Sequence[JudgedPair], verdict: str, resampled: Resampled) -> Agreement:
    """Return a verdict's agreement with people on the pairs that have it."""
    mine = [p for p in pairs if verdict in p.verdicts]
    return agreement(
        [p.people for p in mine],
        [p.verdicts[verdict].correct for p in mine],
        codes([p.command_video for p in mine]) if mine else np.zeros(0, dtype=np.int64),
        resampled,
    )


def _auc_of(pairs: Sequence[JudgedPair], resampled: Resampled) -> Estimate:
    correct = np.array([p.verdicts[ENDS].correct for p in pairs])
    mean = np.array([np.mean(p.ratings) for p in pairs])
    counts = _levels(correct, mean, codes([p.command_video for p in pairs]))
    return percentiles(float(_auc(counts.sum(axis=0))), _auc(resampled(counts)), len(counts))


def _levels(verdicts: BoolArray, mean: FloatArray, video: IntArray) -> FloatArray:
    """Count pairs by video, verdict and mean rating, shape (videos, 2, levels)."""
    values, level = np.unique(mean, return_inverse=True)
    counts = np.zeros((video.max() + 1, 2, len(values)))
    np.add.at(counts, (video, verdicts.astype(int), level), 1.0)
    return counts


def _auc(counts: FloatArray) -> FloatArray:
    no, yes = counts[..., 0, :], counts[..., 1, :]
    below = np.cumsum(no, axis=-1) - no / 2
    pairs = no.sum(axis=-1) * yes.sum(axis=-1)
    return ratio((yes * below).sum(axis=-1), pairs)


Resampled = Callable[[FloatArray], FloatArray]
"""A function from counts by video to sums over resampled videos."""


@short_repr
@dataclass(frozen=True, slots=True)
class Agreement:
    """A verdict against the majority of people."""

    counts: dict[str, int]
    """Pairs by the answers of people and of the judge."""
    kappa: Estimate
    """Cohen's κ; undefined where one side answers all pairs alike, for κ is then 0 regardless of
    the other side."""
    precision: Estimate
    """Share of the pairs accepted by the judge that people accept."""
    recall: Estimate
    """Share of the pairs accepted by people that the judge accepts."""
    accuracy: Estimate
    """Share of pairs with the same answer from both."""

    @property
    def n(self) -> int:
        """Number of pairs."""
        return sum(self.counts.values())


def agreement(
    people: Sequence[bool], judge: Sequence[bool], video: IntArray, resampled: Resampled
) -> Agreement:
    """Compare a judge's answers with people's, with whole videos resampled.

    `video` is the code of each pair's video, shape (n,).
    """
    counts = confusion(people, judge)
    tables = _tables(np.array(people, dtype=np.bool_), np.array(judge, dtype=np.bool_), video)
    drawn = resampled(tables) if len(tables) else np.zeros((1, 2, 2))
    whole = tables.sum(axis=0)

    def bounded(figure: Callable[[FloatArray], FloatArray], missing: Reason) -> Estimate:
        missing = missing if len(tables) else "no data"
        return percentiles(float(figure(whole)), figure(drawn), len(tables), missing)

    vary = whole.any(axis=0).all() and whole.any(axis=1).all()
    kappa = bounded(cohens_kappa, "all alike")
    return Agreement(
        counts,
        kappa if vary or not len(tables) else undefined("all alike"),
        bounded(_precision, "empty class"),
        bounded(_recall, "empty class"),
        bounded(_accuracy, "no data"),
    )


def confusion(people: Sequence[bool], judge: Sequence[bool]) -> dict[str, int]:
    """Count pairs by the answers of people and of the judge."""
    answers = list(zip(people, judge, strict=True))
    words = {True: "yes", False: "no"}
    return {
        f"people_{words[p]}_judge_{words[j]}": answers.count((p, j))
        for p in (True, False)
        for j in (True, False)
    }


def cohens_kappa(table: FloatArray) -> FloatArray:
    """Agreement of two raters beyond chance: J. Cohen (Educ. Psychol. Meas. 20, 1960).

    The table counts items by the answers of both raters, shape (..., k, k). The result has shape
    (...); NaN where both give one and the same answer to all.
    """
    total = table.sum(axis=(-2, -1))
    same = ratio(np.trace(table, axis1=-2, axis2=-1), total)
    by_chance = (table.sum(axis=-1) * table.sum(axis=-2)).sum(axis=-1)
    chance = ratio(by_chance, total**2)
    return ratio(same - chance, 1 - chance)


def _precision(table: FloatArray) -> FloatArray:
    return ratio(table[..., 1, 1], table[..., :, 1].sum(axis=-1))


def _recall(table: FloatArray) -> FloatArray:
    return ratio(table[..., 1, 1], table[..., 1, :].sum(axis=-1))


def _accuracy(table: FloatArray) -> FloatArray:
    return ratio(np.trace(table, axis1=-2, axis2=-1), table.sum(axis=(-2, -1)))


def _tables(people: BoolArray, verdicts: BoolArray, video: IntArray) -> FloatArray:
    """Count pairs by video, people's answer and the judge's, shape (videos, 2, 2)."""
    tables = np.zeros((len(np.unique(video)), 2, 2))
    np.add.at(tables, (video, people.astype(int), verdicts.astype(int)), 1.0)
    return tables
