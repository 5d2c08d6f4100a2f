"""Whether the automatic judge says of commands and videos what people say.

People have judged commands with the videos that they were typed for, and with others. The judge
(:mod:`eval.judging.judge`) says whether the log of the video that was shown leads to what the log
of the command's own video leads to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.runtime.parallel import Team
from eval.judging.judge import Verdict, judge
from eval.judging.replayed import replayed
from eval.statistics.estimates import BoolArray, Estimate, FloatArray, IntArray
from eval.statistics.intervals import percentiles
from eval.statistics.ratings import AGREES, check_judgments, codes, of_study
from eval.statistics.resampling import resampled_sums
from g3.annotation import RATINGS, Judgment
from g3.errors import FormatError
from g3.groundings import Context

ABSENT = "it moves something that the command's world doesn't have"


@dataclass(frozen=True, slots=True)
class JudgedPair:
    """A command with a video, as people and the judge see it.

    Parameters
    ----------
    command, command_video, shown_video
        The words, the video that they were typed for, and the one that was shown.
    ratings
        What people gave it, from 1 to 5, ascending.
    people
        Whether more than half of them agree.
    judge
        What the judge says.
    reason
        Why it says no; empty if it says yes.
    """

    command: str
    command_video: str
    shown_video: str
    ratings: tuple[int, ...]
    people: bool
    judge: bool
    reason: str

    @property
    def original(self) -> bool:
        """Whether it is the command's own video."""
        return self.command_video == self.shown_video


@dataclass(frozen=True, slots=True)
class Validity:
    """How well the judge agrees with the majority of people.

    Parameters
    ----------
    pairs
        All pairs that both have judged.
    left_out
        How many pairs people judged of which a video has no log here.
    study
        Whose judgments they are.
    kappa, accuracy
        Cohen's κ and the part of the pairs of which both say the same, with whole videos
        resampled.
    auc
        How probably a pair that the judge calls right has a higher mean rating than one that it
        calls wrong; equal ones count half. The judge itself has no degrees.
    """

    pairs: tuple[JudgedPair, ...]
    left_out: int
    study: str
    kappa: Estimate
    accuracy: Estimate
    auc: Estimate

    @property
    def disagreements(self) -> tuple[JudgedPair, ...]:
        """Those of which the judge says another thing than most people."""
        return tuple(p for p in self.pairs if p.people != p.judge)


def judge_validity(
    corpus: Corpus, *, seed: int, draws: int, study: str = "", team: Team | None = None
) -> Validity:
    """Compare the judge with the people whose judgments a corpus holds.

    `team` makes the resamples (:func:`eval.statistics.resampling.resampled_sums`).

    Raises
    ------
    FormatError
        If the corpus has no judgments, none of the study, or no log of any video judged.
    """
    if not corpus.judgments:
        raise FormatError("the corpus has no judgments", fix="give one with ratings of videos")
    check_judgments(corpus.judgments, {command.video for command in corpus.commands.values()})
    mine = of_study(corpus.judgments, study)
    contexts = contexts_of_videos(corpus)
    pairs, left_out = _judged(mine, contexts)
    if not pairs:
        raise FormatError(
            "no judged pair has the logs of both videos", fix="give a corpus that has their logs"
        )
    people, said = (np.array([getattr(p, who) for p in pairs]) for who in ("people", "judge"))
    mean = np.array([np.mean(p.ratings) for p in pairs])
    video = codes([p.command_video for p in pairs])

    def resampled(counts: FloatArray) -> FloatArray:
        # The same seed for each figure, so that all are of the same videos.
        return resampled_sums(counts, rng=np.random.default_rng(seed), draws=draws, team=team)

    return Validity(
        tuple(pairs),
        left_out,
        mine[0].study,
        _bounded(cohens_kappa, _tables(people, said, video), resampled),
        _bounded(_accuracy, _tables(people, said, video), resampled),
        _bounded(_auc, _levels(said, mean, video), resampled),
    )


def known_validity(corpora: Iterable[Corpus], *, seed: int, draws: int) -> Validity | None:
    """The judge's validity on the first corpus that tells; None if none does."""
    for corpus in corpora:
        contexts = contexts_of_videos(corpus)
        if any({j.command_video, j.shown_video} <= contexts.keys() for j in corpus.judgments):
            return judge_validity(corpus, seed=seed, draws=draws)
    return None


def contexts_of_videos(corpus: Corpus) -> dict[str, Context]:
    """The world and log of each video; a context's id is a video's too."""
    found = dict(corpus.contexts)
    for annotation in corpus.annotations:
        found.setdefault(annotation.command.video, annotation.context)
    return found


def confusion(pairs: Sequence[JudgedPair]) -> dict[str, int]:
    """How many pairs there are of each thing that people and the judge say."""
    names = {(p, j): f"people_{_said(p)}_judge_{_said(j)}" for p in (1, 0) for j in (1, 0)}
    return {name: sum((p.people, p.judge) == which for p in pairs) for which, name in names.items()}


def cohens_kappa(table: FloatArray) -> FloatArray:
    """Agreement of two raters beyond chance: J. Cohen (Educ. Psychol. Meas. 20, 1960).

    Parameters
    ----------
    table
        Counts by what each of them says, shape (..., k, k).

    Returns
    -------
    ndarray
        Shape (...); NaN where both say the same of everything.
    """
    total = table.sum(axis=(-2, -1))
    same = np.trace(table, axis1=-2, axis2=-1) / total
    chance = (table.sum(axis=-1) * table.sum(axis=-2)).sum(axis=-1) / total**2
    found: FloatArray = np.divide(
        same - chance, 1 - chance, out=np.full(np.shape(total), np.nan), where=chance < 1
    )
    return found


def _said(yes: int) -> str:
    return "yes" if yes else "no"


def _judged(
    judgments: Sequence[Judgment], contexts: Mapping[str, Context]
) -> tuple[list[JudgedPair], int]:
    ratings: dict[tuple[str, str, str], list[int]] = {}
    for j in judgments:
        key = (j.command, j.command_video, j.shown_video)
        ratings.setdefault(key, []).append(RATINGS.index(j.rating) + 1)
    verdicts: dict[tuple[str, str], Verdict] = {}
    pairs = []
    for (text, own, shown), given in ratings.items():
        if own not in contexts or shown not in contexts:
            continue
        if (own, shown) not in verdicts:
            verdicts[own, shown] = _verdict(contexts[own], contexts[shown])
        verdict = verdicts[own, shown]
        pairs.append(
            JudgedPair(
                text,
                own,
                shown,
                tuple(sorted(given)),
                2 * sum(r >= AGREES for r in given) > len(given),
                verdict.correct,
                verdict.reason,
            )
        )
    return pairs, len(ratings) - len(pairs)


def _verdict(own: Context, shown: Context) -> Verdict:
    state = replayed(own, shown)
    return Verdict(False, ABSENT) if state is None else judge(own, state)


# Resampling whole videos: a figure is a function of counts that add up


def _tables(people: BoolArray, said: BoolArray, video: IntArray) -> FloatArray:
    """Counts by video, of what people say and of what the judge says, shape (videos, 2, 2)."""
    tables = np.zeros((video.max() + 1, 2, 2))
    np.add.at(tables, (video, people.astype(int), said.astype(int)), 1.0)
    return tables


def _levels(said: BoolArray, mean: FloatArray, video: IntArray) -> FloatArray:
    """Counts by video, of what the judge says and of mean ratings, shape (videos, 2, levels)."""
    values, level = np.unique(mean, return_inverse=True)
    counts = np.zeros((video.max() + 1, 2, len(values)))
    np.add.at(counts, (video, said.astype(int), level), 1.0)
    return counts


def _bounded(
    figure: Callable[[FloatArray], FloatArray],
    counts: FloatArray,
    resampled: Callable[[FloatArray], FloatArray],
) -> Estimate:
    return percentiles(float(figure(counts.sum(axis=0))), figure(resampled(counts)))


def _accuracy(table: FloatArray) -> FloatArray:
    found: FloatArray = np.trace(table, axis1=-2, axis2=-1) / table.sum(axis=(-2, -1))
    return found


def _auc(counts: FloatArray) -> FloatArray:
    no, yes = counts[..., 0, :], counts[..., 1, :]
    below = np.cumsum(no, axis=-1) - no / 2
    pairs = no.sum(axis=-1) * yes.sum(axis=-1)
    found: FloatArray = np.divide(
        (yes * below).sum(axis=-1), pairs, out=np.full(np.shape(pairs), np.nan), where=pairs > 0
    )
    return found
