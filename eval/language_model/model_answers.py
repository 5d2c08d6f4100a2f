"""The language model as a grounder and as a judge of Table 3, with the name ``llm``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from hashlib import sha256

from corpus_tools.following.plan_steps import ReadPlan, read_steps
from corpus_tools.runtime.progress import OnProgress
from eval.judging.judge import Verdict
from eval.judging.judge_registry import JudgedPlan
from eval.language_model.chat_endpoint import Endpoint, missing
from eval.language_model.plan_prompt import (
    PlanReply,
    VerdictReply,
    judge_messages,
    judge_prompt,
    plan_messages,
    plan_prompt,
)
from eval.language_model.structured_replies import UnusableReplyError, ask_for
from eval.table_3.grounder_registry import PlanGrounder, PlanTask, Proposal
from g3.actions.action_kinds import KINDS
from g3.errors import CorpusError, FormatError

NAME = "llm"
PLAN, JUDGE = "plan", "judge"
"""Purposes of requests."""


@dataclass(frozen=True)
class LanguageModelGrounder(PlanGrounder):
    """Plans by a language model.

    All plans are requested before the first is judged, several at the same time. An unusable reply
    is requested again; after three of them the command counts as refused.
    """

    endpoint: Endpoint

    name = NAME

    @property
    def about(self) -> Mapping[str, object]:
        """The model, and a digest of its prompt."""
        return {**self.endpoint.about, "prompt": _digest(plan_prompt())}

    def missing(self) -> str:
        """Return why the grounder can't be run here; empty if it can."""
        return missing()

    def prepare(self, tasks: Sequence[PlanTask], on_progress: OnProgress) -> None:
        """Request plans for all tasks; after a failure, received ones are kept."""
        with ThreadPoolExecutor(self.endpoint.at_once) as threads:
            asked = [threads.submit(self.propose, task) for task in tasks]
            try:
                for count, done in enumerate(as_completed(asked), start=1):
                    done.result()
                    on_progress("asking the language model", count, len(tasks))
            except BaseException:
                threads.shutdown(wait=False, cancel_futures=True)  # nothing more is to be paid for
                raise

    def propose(self, task: PlanTask, learned: object = None) -> Proposal:
        """Make a plan."""

        def use(reply: PlanReply) -> Proposal:
            plan: ReadPlan = read_steps(reply.actions, task.start)
            if plan.why_not:
                raise FormatError(plan.why_not)
            return Proposal(plan.actions, reply.probability, reply.reason)

        try:
            return ask_for(
                self.endpoint,
                plan_messages(task),
                PlanReply,
                use,
                purpose=PLAN,
                choices={"action": list(KINDS)},
            )
        except UnusableReplyError as error:
            return Proposal(note=str(error))


@dataclass(frozen=True)
class LanguageModelJudge:
    """Verdicts by a language model."""

    endpoint: Endpoint

    name = NAME

    @property
    def about(self) -> Mapping[str, object]:
        """The model, and a digest of its prompt."""
        return {**self.endpoint.about, "prompt": _digest(judge_prompt())}

    @property
    def at_once(self) -> int:
        """Number of plans that are sent to the model at the same time."""
        return self.endpoint.at_once

    def verdict(self, plan: JudgedPlan) -> Verdict:
        """Judge a plan; a reply that can't be used is a no."""

        def use(reply: VerdictReply) -> Verdict:
            return Verdict(reply.correct, "" if reply.correct else reply.reason or "it says so")

        try:
            return ask_for(self.endpoint, judge_messages(plan), VerdictReply, use, purpose=JUDGE)
        except UnusableReplyError as error:
            return Verdict(False, str(error))


def check_installed() -> None:
    """Refuse to go on without the extra for language models."""
    if why := missing():
        raise CorpusError(why, fix="or leave the language model out")


def _digest(prompt: str) -> str:
    """Return a digest that identifies a prompt; each kept reply has all of the prompt."""
    return f"sha256:{sha256(prompt.encode()).hexdigest()}"
