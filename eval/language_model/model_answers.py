"""The language model as a grounder, as a parser and as a judge, with the name ``llm``."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field, replace
from hashlib import sha256
from importlib.resources import files
from typing import Any, ClassVar, Generic, TypeVar

import msgspec

from corpus_tools.corpus.annotated_trees import Annotated
from corpus_tools.corpus.answer_records import PlanStep, Probability, SceneShown
from corpus_tools.following.plan_steps import ReadPlan, read_steps, scene_shown
from corpus_tools.importers.treebank import trees_of
from corpus_tools.runtime.progress import OnProgress
from corpus_tools.runtime.terminal import note
from eval.judging.judge import Verdict
from eval.judging.judge_registry import JudgedPlan
from eval.language_model.chat_endpoint import Endpoint, Message, ask, forecast, missing
from eval.parsing.parser_registry import ParseTask, TextParser
from eval.table_3.grounder_registry import PlanGrounder, PlanTask, Proposal
from g3.actions.action_kinds import KINDS, ActionKind
from g3.actions.action_words import MAP, PlanWords
from g3.actions.forklift_actions import DRIVE_BETWEEN
from g3.actions.grounding_candidates import carrier
from g3.actions.robot_state import State
from g3.errors import CorpusError, FormatError, SDCError
from g3.geometry.footprints import centre
from g3.language.parsing.trees import Parse, Tree
from g3.sdc.clauses import CHILD_FIELDS, SDC, breadth_first
from g3.sdc.sdc_notation import format_brackets

Form = TypeVar("Form", bound=msgspec.Struct)
Value = TypeVar("Value")

ROUNDS = 3
"""Usual number of requests for one reply; each states the error of the one before."""
SHOWN = 200


class UnusableReplyError(CorpusError):
    """A language model has given no reply that can be used."""


@dataclass(frozen=True)
class Inquiry(Generic[Form, Value]):
    """Messages that request a reply in a form, and the conversion of the reply.

    Parameters
    ----------
    use
        Converts the reply; raises a FormatError where that can't be done.
    choices
        Allowed values of the form's fields, by name, for servers that constrain a model to them.
    """

    messages: Sequence[Message]
    form: type[Form]
    use: Callable[[Form], Value]
    choices: Mapping[str, Sequence[str]] = field(default_factory=dict)


def ask_for(
    endpoint: Endpoint, asked: Inquiry[Any, Value], *, purpose: str, rounds: int = ROUNDS
) -> Value:
    """Ask for a reply in a form, and convert it.

    Parameters
    ----------
    rounds
        Number of requests at most.

    Raises
    ------
    UnusableReplyError
        If no reply can be used.
    CorpusError
        If the endpoint gives no reply.
    """
    said, schema = list(asked.messages), _schema(asked.form, asked.choices)
    problem = ""
    for _ in range(rounds):
        reply = ask(endpoint, said, schema, purpose=purpose)
        try:
            return asked.use(msgspec.json.decode(json_in(reply.text), type=asked.form))
        except (FormatError, msgspec.MsgspecError, RecursionError) as error:
            problem = str(error)
        said += [
            {"role": "assistant", "content": reply.text},
            {
                "role": "user",
                "content": f"That can't be used: {problem}. Give the whole JSON again.",
            },
        ]
    raise UnusableReplyError(f"no reply of the language model can be used: {problem[:SHOWN]}")


def _schema(form: type[msgspec.Struct], choices: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    """Return the JSON Schema of a form: an object at the top, for endpoints, without prose."""
    whole = msgspec.json.schema(form)
    root = whole["$defs"].pop(form.__name__)
    bare: dict[str, Any] = _without_prose({**root, "$defs": whole["$defs"]})
    for part in (bare, *bare["$defs"].values()):
        for name in part.get("properties", {}).keys() & choices.keys():
            part["properties"][name] |= {"enum": list(choices[name])}
    return bare


def _without_prose(part: Any) -> Any:
    if isinstance(part, dict):
        kept = ((k, v) for k, v in part.items() if k not in ("title", "description"))
        return {key: _without_prose(value) for key, value in kept}
    return [_without_prose(item) for item in part] if isinstance(part, list) else part


def json_in(text: str) -> str:
    """Return the JSON object in a reply, without the text that models put around it.

    >>> json_in('Sure: {"correct": true}!')
    '{"correct": true}'
    """
    first, last = text.find("{"), text.rfind("}")
    return text[first : last + 1] if 0 <= first < last else text


def _prompt(name: str, **parts: object) -> str:
    """Return a text of the folder ``prompts``, with its parts filled in."""
    text = files("eval.language_model").joinpath(f"prompts/{name}.txt").read_text(encoding="utf-8")
    return text.removesuffix("\n").format(**parts) if parts else text.removesuffix("\n")


EXAMPLES = tuple(_prompt("examples").split("\n\n"))
"""Examples of the prompt where no corpus to learn from is given."""
MOST_EXAMPLES, LONGEST_EXAMPLE = 6, 160
"""Number of examples from a corpus, and their longest text in characters."""


class PlanReply(msgspec.Struct, frozen=True):
    """A plan, as a language model is to give it."""

    actions: tuple[PlanStep, ...]
    probability: Probability = 0.0
    reason: str = ""


class ParseReply(msgspec.Struct, frozen=True):
    """Clauses in bracket notation, as a language model is to give them."""

    trees: tuple[str, ...]
    taken_back: str = ""


class Reading(ParseReply, frozen=True, kw_only=True):
    """One way to understand a command, as a language model is to give it."""

    share: Probability


class ReadingsReply(msgspec.Struct, frozen=True):
    """Several ways to understand a command, as a language model is to give them."""

    readings: tuple[Reading, ...]


class VerdictReply(msgspec.Struct, frozen=True):
    """A verdict, as a language model is to give it."""

    correct: bool
    reason: str = ""


def plan_prompt() -> str:
    """Return the text before any command."""
    actions = "\n".join(f'- "{kind}": {_takes(kind)} {kind.description}' for kind in KINDS.values())
    return _prompt("plan", scene=_prompt("scene"), actions=actions)


def judge_prompt() -> str:
    """Return the text before any plan."""
    return _prompt("judge", scene=_prompt("scene"))


def plan_messages(task: PlanTask) -> list[Message]:
    """Return the messages that request a plan."""
    return _messages(
        plan_prompt(), f"World: {_compact(scene_shown(task.start))}\nCommand: {task.text}"
    )


def judge_messages(plan: JudgedPlan) -> list[Message]:
    """Return the messages that request a verdict."""
    start = plan.execution.start
    world = _compact(scene_shown(start))
    done = "\n".join(f"- {line}" for line in _done(plan, start))
    asked = f"World: {world}\nCommand: {plan.text}\nWhat the robot did:\n{done}"
    return _messages(judge_prompt(), asked)


def parse_prompt(examples: Sequence[str] = EXAMPLES, most: int = 1) -> str:
    """Return the text before any command whose clauses are requested."""
    reply = _prompt("reading" if most == 1 else "readings", most=most, trees=_prompt("trees"))
    return _prompt("parse", examples="\n\n".join(examples), reply=reply)


def chosen_examples(commands: Sequence[Annotated]) -> tuple[str, ...]:
    """Return commands with their trees that show as many kinds of fields as possible.

    Of those that show as many new ones, it takes the shortest.
    """
    shown: set[tuple[str, str, str]] = set()
    texts = {one.command.text.strip(): one for one in commands if one.sdcs}
    left = {
        " ".join(text.split()): (_kinds(one.sdcs), format_brackets(one.sdcs))
        for text, one in texts.items()
        if len(text) <= LONGEST_EXAMPLE
    }
    result = []
    for _ in range(min(MOST_EXAMPLES, len(left))):
        text = min(left, key=lambda text: (-len(left[text][0] - shown), len(text), text))
        kinds, trees = left.pop(text)
        shown |= kinds
        result.append(f"{text}\n{trees}")
    return tuple(result)


def _kinds(sdcs: Sequence[SDC]) -> set[tuple[str, str, str]]:
    """Return each field of clauses, by the clause's type, with the type of what is in it."""
    return {
        (sdc.type, field, child.type)
        for sdc in breadth_first(sdcs)
        for field in CHILD_FIELDS
        for child in sdc.children(field)
    }


def check_trees(sdcs: Sequence[SDC]) -> None:
    """Refuse trees that the notation can write, but no annotator would."""
    used: set[int] = set()
    for sdc in sdcs:
        if sdc.type not in ("EVENT", "OBJECT"):
            raise FormatError(f"a top-level clause is a {sdc.type}", fix="make it an EVENT")
    for sdc in breadth_first(sdcs):
        for figure in sdc.figure:
            if figure.type != "OBJECT":
                raise FormatError(f"a figure is of the type {figure.type}", fix="make it an OBJ")
        for word in (*sdc.words, *sdc.relation):
            letters = set(range(word.start, word.start + len(word.text)))
            if letters & used:
                raise FormatError(f"the word {word.text!r} is in two clauses", fix="use it once")
            used |= letters


def _messages(system: str, user: str) -> list[Message]:
    return [{"role": "system", "content": system}, {"role": "user", "content": user}]


def _compact(scene: SceneShown) -> str:
    return msgspec.json.encode(scene).decode()


def _takes(kind: ActionKind) -> str:
    """Return the fields of an action, in brackets."""
    units = {"m": "metres", "rad": "degrees, to the left if positive", "s": "seconds"}
    fields = ["object"] if kind.handles else []
    fields += ["on, near or at"] if kind.leaves else []
    aim = "target, two of them" if kind is DRIVE_BETWEEN else "target or to"
    fields += [aim] if kind.aims else []
    fields += [f"amount in {units[kind.unit]}"] if kind.unit else []
    return f"({'; '.join(fields)})"


def _done(plan: JudgedPlan, start: State) -> Sequence[str]:
    """Describe an execution by its traces, for a log has no actions."""
    execution = plan.execution
    words = PlanWords(replace(start, frame=MAP), plan.actions)
    lines = [f"action: {words.action(action)}" for action in plan.actions]
    for load in execution.carried:
        after = execution.end.thing(load.id)
        if load.lowered is None:
            where = "is on the forks at the end"
        else:
            under = carrier(execution.end, load.id)
            x, y = centre(after.prism)
            where = f"ends at [{x:.1f}, {y:.1f}] on {under.id if under else 'the ground'}"
        taken = "was on the forks at the start" if load.id == start.held else "was picked up"
        lines.append(f"{load.id} {taken} and {where}")
    if not execution.carried:
        lines.append("no load was moved")
    way = execution.way[:: max(1, len(execution.way) // 12)]
    points = ", ".join(f"[{x:.1f}, {y:.1f}]" for x, y, _ in (*way, execution.way[-1]))
    x, y, yaw = execution.way[-1]
    lines.append(f"the robot drove by {points}")
    lines.append(f"it ends at [{x:.1f}, {y:.1f}], heading {_degrees(yaw):.0f} degrees")
    return lines


def _degrees(radians: float) -> float:
    return round(math.degrees(radians)) % 360 + 0.0


NAME = "llm"
PARSER_ROW = "llm-parser"
"""Name of the parser's row, which may stand beside the grounder's."""
PLAN, PARSE, JUDGE = "plan", "parse", "judge"
"""Purposes of requests."""


@dataclass(frozen=True)
class _LanguageModel:
    """A language model at an endpoint, asked for one purpose."""

    endpoint: Endpoint

    name = NAME
    purpose: ClassVar[str]
    rounds: ClassVar[int] = ROUNDS

    @property
    def prompt(self) -> str:
        """The text before any question."""
        raise NotImplementedError

    @property
    def about(self) -> Mapping[str, object]:
        """The model, and a digest of its prompt."""
        digest = sha256(self.prompt.encode()).hexdigest()
        return {**self.endpoint.about, "prompt": f"sha256:{digest}"}

    def missing(self) -> str:
        """Return why no language model can be asked here; empty if one can."""
        return missing()

    def _ask(self, asked: Inquiry[Any, Value], otherwise: Callable[[str], Value]) -> Value:
        """Return what a reply is converted to, or what is to be used without a usable one."""
        try:
            return ask_for(self.endpoint, asked, purpose=self.purpose, rounds=self.rounds)
        except UnusableReplyError as error:
            return otherwise(str(error))

    def _ask_for_all(self, inquiries: Sequence[Inquiry[Any, Any]], on_progress: OnProgress) -> None:
        """Ask several at a time, so that replies are kept; after a failure nothing more is asked.

        What will be sent is announced first.
        """
        schemas = ((one.messages, _schema(one.form, one.choices)) for one in inquiries)
        note(forecast(self.endpoint, schemas, purpose=self.purpose, rounds=self.rounds))
        with ThreadPoolExecutor(self.endpoint.at_once) as threads:
            asked = [threads.submit(self._ask, one, lambda _why: None) for one in inquiries]
            try:
                for count, done in enumerate(as_completed(asked), start=1):
                    done.result()
                    on_progress("asking the language model", count, len(asked))
            except BaseException:
                threads.shutdown(wait=False, cancel_futures=True)  # nothing more is to be paid for
                raise


@dataclass(frozen=True)
class LanguageModelGrounder(_LanguageModel, PlanGrounder):
    """Plans by a language model.

    All plans are requested before the first is judged, several at the same time. An unusable reply
    is requested again; after three of them the command counts as refused.
    """

    purpose = PLAN

    @property
    def prompt(self) -> str:
        """The text before any command."""
        return plan_prompt()

    def prepare(self, tasks: Sequence[PlanTask], on_progress: OnProgress) -> None:
        """Request plans for all tasks; after a failure, received ones are kept."""
        self._ask_for_all(list(map(self._inquiry, tasks)), on_progress)

    def propose(self, task: PlanTask, learned: object = None) -> Proposal:
        """Make a plan."""
        return self._ask(self._inquiry(task), lambda why: Proposal(note=why))

    def _inquiry(self, task: PlanTask) -> Inquiry[PlanReply, Proposal]:
        def use(reply: PlanReply) -> Proposal:
            plan: ReadPlan = read_steps(reply.actions, task.start)
            if plan.why_not:
                raise FormatError(plan.why_not)
            return Proposal(plan.actions, reply.probability, reply.reason)

        return Inquiry(plan_messages(task), PlanReply, use, {"action": list(KINDS)})


@dataclass(frozen=True)
class LanguageModelParser(_LanguageModel, TextParser):
    """Clauses by a language model, in bracket notation.

    All texts are sent before the first tree is compared, several at the same time. A reply that
    leaves the grammar, or has words that the text lacks, is requested once more with the error.
    Where that fails, too, the text has no trees, and a note says why.

    Parameters
    ----------
    most
        Number of trees to ask for, at most; several come with the shares that the model states.
    """

    most: int = 1

    name = PARSER_ROW
    purpose = PARSE
    rounds = 2

    @property
    def prompt(self) -> str:
        """The text before any command, with the examples that stand in for a corpus's."""
        return parse_prompt(most=self.most)

    @property
    def learns(self) -> bool:
        """True: its prompt has examples of the corpus to learn from."""
        return True

    def fit(self, commands: Sequence[Annotated]) -> tuple[str, ...]:
        """Return the examples of its prompt."""
        return chosen_examples(commands)

    def prepare(self, tasks: Sequence[ParseTask], on_progress: OnProgress) -> None:
        """Request trees of all texts; after a failure, received ones are kept."""
        self._ask_for_all([self._inquiry(*task) for task in tasks], on_progress)

    def parse(self, text: str, learned: Sequence[str] | None = None) -> Parse:
        """Parse a text into its trees."""
        return self._ask(self._inquiry(text, learned), lambda why: Parse(text, (), why))

    def _inquiry(self, text: str, learned: Sequence[str] | None) -> Inquiry[Any, Parse]:
        prompt = parse_prompt(learned or EXAMPLES, self.most)
        messages = _messages(prompt, f"Command: {text}")

        def one(reply: ParseReply) -> Parse:
            sdcs = _trees_in(reply, text)
            return Parse(text, (Tree(sdcs, 1.0),) if sdcs else ())

        def several(reply: ReadingsReply) -> Parse:
            shares: dict[tuple[SDC, ...], float] = defaultdict(float)
            for reading in reply.readings:
                shares[_trees_in(reading, text)] += reading.share
            if reply.readings and not sum(shares.values()):
                raise FormatError("all shares are 0")
            total = max(1.0, sum(shares.values()))
            likely = sorted(shares.items(), key=lambda item: -item[1])[: self.most]
            trees = (Tree(sdcs, share / total) for sdcs, share in likely if sdcs and share)
            return Parse(text, tuple(trees))

        if self.most == 1:
            return Inquiry(messages, ParseReply, one)
        return Inquiry(messages, ReadingsReply, several)


def _trees_in(reply: ParseReply, text: str) -> tuple[SDC, ...]:
    """Return the trees of a reply to a text; FormatError where it leaves the grammar."""
    try:
        sdcs, _ = trees_of(reply.trees, reply.taken_back, text)
    except SDCError as error:
        raise FormatError(error.what, where=error.where, fix=error.fix) from error
    check_trees(sdcs)
    return sdcs


@dataclass(frozen=True)
class LanguageModelJudge(_LanguageModel):
    """Verdicts by a language model."""

    purpose = JUDGE

    @property
    def prompt(self) -> str:
        """The text before any plan."""
        return judge_prompt()

    @property
    def at_once(self) -> int:
        """Number of plans that are sent to the model at the same time."""
        return self.endpoint.at_once

    def verdict(self, plan: JudgedPlan) -> Verdict:
        """Judge a plan; a reply that can't be used is a no."""

        def use(reply: VerdictReply) -> Verdict:
            return Verdict(reply.correct, "" if reply.correct else reply.reason or "it says so")

        asked = Inquiry(judge_messages(plan), VerdictReply, use)
        return self._ask(asked, lambda why: Verdict(False, why))


def check_installed() -> None:
    """Refuse to go on without the extra for language models."""
    if why := missing():
        raise CorpusError(why, fix="or leave the language model out")
