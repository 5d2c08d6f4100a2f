"""A study's file: its tasks and its people (``docs/annotation.md`` describes it)."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

import msgspec

from annotation_app.core.languages import N_, SOURCE, gettext
from annotation_app.store.models import TaskName

Name: TypeAlias = Annotated[str, msgspec.Meta(pattern=r"^[a-z0-9][a-z0-9-]*$", max_length=60)]
Text: TypeAlias = Annotated[str, msgspec.Meta(max_length=10_000)]
Line: TypeAlias = Annotated[str, msgspec.Meta(min_length=1, max_length=1000)]
Suggestions: TypeAlias = Literal["on", "off", "half"]
Watching: TypeAlias = Literal["required", "flagged"]
Language: TypeAlias = Annotated[
    str, msgspec.Meta(pattern=r"^[a-z]{2,3}(-[A-Za-z]+)*$", max_length=20)
]
Share: TypeAlias = Annotated[float, msgspec.Meta(ge=0, le=0.5)]
LONGEST_GROUP = 100
Group: TypeAlias = Annotated[str, msgspec.Meta(min_length=1, max_length=LONGEST_GROUP)]
"""Name of a group of people."""

CONSENT = N_("""You will watch short videos of a robot, or read what others wrote about them.
What you type and choose is kept without your name and may be published for research.
You may stop at any time by closing the page.""")
STATEMENT = N_("The {robot} in the video is executing the above spoken command.")
SCALE = (
    N_("Strongly disagree"),
    N_("Disagree"),
    N_("Neither agree nor disagree"),
    N_("Agree"),
    N_("Strongly agree"),
)
REASONS = (
    N_("The task isn’t finished"),
    N_("The wrong thing is handled"),
    N_("Something falls or is knocked over"),
    N_("The robot hits something"),
    N_("The robot stops or hesitates"),
    N_("The episode begins too late or ends too early"),
    N_("It can’t be seen well"),
)
MOST_REASONS = 20
ROBOT = N_("forklift")
Scale: TypeAlias = tuple[Line, Line, Line, Line, Line]


class WrongAnswer(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An answer to a practice item as its page sends it, and the reason why it is wrong."""

    answer: dict[str, Any]
    why: Line


class PracticeItem(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A practice item of a study's own.

    Parameters
    ----------
    video
        Which of the study's videos it shows.
    good
        What people read whose rating is right; of other tasks, which judge nothing, some answers to
        compare theirs with.
    command
        What is rated, segmented, grounded or checked.
    clauses
        Its clauses in bracket notation, to ground and to check; if empty, the parser's.
    answer
        The right answer as its page sends it, if there is one.
    wrong
        Wrong answers.
    right
        The ratings that are right.
    again
        What people read who answer otherwise.
    """

    video: Line
    good: Line
    command: Line | None = None
    clauses: Text = ""
    answer: dict[str, Any] | None = None
    wrong: tuple[WrongAnswer, ...] = ()
    right: tuple[Annotated[int, msgspec.Meta(ge=1, le=5)], ...] = (4, 5)
    again: Line = N_("Watch the video again.")


class Labels(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Names by which pages call the things that they number, and the places that they letter."""

    thing: Line = N_("Thing")
    place: Line = N_("Place")
    robot: Line = N_("the robot")


Adoption: TypeAlias = (
    Literal["all", "majority", "adjudicator"] | Annotated[float, msgspec.Meta(gt=0.5, le=1)]
)


class TaskConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Requirements of a task's items.

    Parameters
    ----------
    answers
        How many people answer each item.
    overlap
        Share of the items that so many people answer, for agreement, drawn from the study's seed.
        One person answers each of the others.
    adoption
        When an answer is adopted, if people decide between them: once all wanted ones are there and
        all agree, more than half do, or a share of them does; or only by an adjudicator.
    lease_minutes
        How long somebody has an item before somebody else may get it.
    role
        Who may do it: everybody, or annotators, who have a login.
    practice
        Whether the practice example comes first, if the task has one.
    suggestions
        Whether people see what a program suggests, if the task has suggestions: all do, nobody
        does, or for half of the items, drawn from the study's seed and the item's id.
    suggestions_from
        Least probability of a program's suggestion that is shown; the task's own if there is none.
    drawing
        Whether people may draw boxes of things that nobody has marked, in Ground, in the pictures
        of one's own videos.
    practice_items
        What people practise with, instead of the example with the boat.
    title, summary, prompt
        What people read of the task, instead of its own words.
    styles
        The styles of text that people write, if the task has several: those named, with prompts
        instead of the usual ones where there are some. None named are the usual ones.
    instructions
        The same, as Markdown without HTML and pictures.
    """

    answers: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 1
    overlap: Annotated[float, msgspec.Meta(ge=0, le=1)] = 1.0
    adoption: Adoption = "all"
    lease_minutes: Annotated[float, msgspec.Meta(gt=0, le=10_080)] = 30.0
    role: Literal["worker", "annotator"] = "worker"
    practice: bool = True
    suggestions: Suggestions = "on"
    suggestions_from: Annotated[float, msgspec.Meta(ge=0, le=1)] | None = None
    drawing: bool = False
    practice_items: tuple[PracticeItem, ...] = ()
    title: Line | None = None
    summary: Line | None = None
    prompt: Line | None = None
    styles: tuple[Name, ...] | dict[Name, Line | None] = ()
    instructions: Text = ""


class Question(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Something that people are asked about themselves; free text without choices."""

    id: Name
    text: Line
    choices: tuple[Line, ...] = ()
    required: bool = False


class Payment(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Payment for an item: people see it, and providers pay it."""

    amount: Annotated[float, msgspec.Meta(ge=0, le=1000)]
    currency: Annotated[str, msgspec.Meta(pattern="^[A-Z]{3}$")] = "USD"
    bonus: Annotated[float, msgspec.Meta(ge=0, le=1000)] = 0.0


class KnownCommand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A command that is right for one video and plainly wrong for another."""

    text: Line
    video: str
    wrong_video: str


class RatedPair(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A command to be rated with a video, and the video that it was typed for."""

    text: Line
    video: str
    own_video: str


class StudyConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A study as it is written.

    Parameters
    ----------
    name
        Of the study, in addresses.
    title
        What people read.
    locale
        The language that the pages speak, and people write in.
    videos
        Folder that ``ct render-videos`` has filled, folder of mp4 and webm files, or table (CSV or
        JSONL) that names such files; from the study's file.
    only
        Names of the videos to use; all if empty.
    commands
        Table (CSV or JSONL) of commands for the videos, which nobody needs to type.
    subtasks
        Table (CSV or JSONL) of steps that a model proposed, which people correct; of several
        models a table each, by their names.
    vocabulary
        The steps that people choose from in the task subtasks; if empty, they type any.
    vocabulary_grows
        How many people must have used a new step before it is offered to others; if left out, the
        vocabulary is closed.
    things
        COCO JSON file of what is where in the pictures of one's own videos.
    tasks
        Those that are done.
    robot
        What ``{robot}`` stands for in the statement and the consent.
    statement
        What raters agree with, or don't.
    scale
        How much, from the least to the most.
    reasons
        Reasons against an episode, from which people choose.
    labels
        What things are called.
    access
        Whether anybody with the address may take part, or only who is invited.
    groups
        The groups of people that alone get the items, with their shares: of 2 and 1, the first gets
        two thirds.
    qualification
        What people must confirm of themselves, each with a box to tick.
    attention_checks
        Part of a rater's items that has a known answer.
    known_commands
        What attention checks are made of.
    pairs
        Commands with videos to be rated, beside those that people type.
    watching
        Whether answers of people who can't have watched the video are refused, or kept with a flag.
    seed
        What random videos and negatives are drawn with.
    retention_days
        How many days after the study was closed what leads from answers to people is erased; it
        is kept if there is none.
    """

    name: Name
    title: Line
    locale: Language = SOURCE
    videos: Line = "videos"
    only: tuple[str, ...] = ()
    commands: Line | None = None
    subtasks: Line | dict[Line, Line] | None = None
    vocabulary: tuple[Line, ...] = ()
    vocabulary_grows: Annotated[int, msgspec.Meta(ge=1, le=1000)] | None = None
    things: Line | None = None
    tasks: dict[TaskName, TaskConfig]
    access: Literal["open", "invited"] = "open"
    groups: dict[Group, Annotated[float, msgspec.Meta(gt=0, le=1000)]] = {}
    robot: Line = ROBOT
    statement: Line = STATEMENT
    scale: Scale = SCALE
    reasons: Annotated[tuple[Line, ...], msgspec.Meta(max_length=MOST_REASONS)] = REASONS
    labels: Labels = Labels()
    consent: Text = CONSENT
    questions: tuple[Question, ...] = ()
    qualification: tuple[Line, ...] = ()
    payment: Payment | None = None
    attention_checks: Share = 0.0
    known_commands: tuple[KnownCommand, ...] = ()
    pairs: tuple[RatedPair, ...] = ()
    watching: Watching = "required"
    seed: int = 0
    retention_days: Annotated[int, msgspec.Meta(ge=0, le=36_500)] | None = None


def told(text: str, robot: str) -> str:
    """Return a text with the robot's name in it."""
    return text.replace("{robot}", robot)


def language_of(stored: dict[str, Any]) -> str:
    """Return the language of a study, from its record in the database."""
    return str(stored.get("locale", SOURCE))


def in_its_language(config: StudyConfig) -> StudyConfig:
    """Return a study with the texts that its file leaves out in the page's language."""
    usual = StudyConfig(name=config.name, title=config.title, tasks={})
    return msgspec.structs.replace(
        config,
        scale=tuple(map(gettext, SCALE)) if config.scale == SCALE else config.scale,
        labels=msgspec.structs.replace(
            config.labels, **_usual_texts(config.labels, usual.labels, "thing", "place", "robot")
        ),
        tasks={name: _in_its_language(task) for name, task in config.tasks.items()},
        **_usual_texts(config, usual, "robot", "statement", "consent"),
    )


def _in_its_language(task: TaskConfig) -> TaskConfig:
    usual = PracticeItem(video="-", good="-")
    items = (
        msgspec.structs.replace(item, **_usual_texts(item, usual, "again"))
        for item in task.practice_items
    )
    return msgspec.structs.replace(task, practice_items=tuple(items))


def _usual_texts(one: msgspec.Struct, usual: msgspec.Struct, *fields: str) -> dict[str, str]:
    """Return translations of the texts that still are the English defaults."""
    same = (name for name in fields if getattr(one, name) == getattr(usual, name))
    return {name: gettext(getattr(usual, name)) for name in same}


def stored(config: StudyConfig) -> dict[str, Any]:
    """Return a study as the database keeps it: without its pairs, which are items."""
    value: dict[str, Any] = msgspec.to_builtins(msgspec.structs.replace(config, pairs=()))
    return value


def restored(value: dict[str, Any]) -> StudyConfig:
    """Return the study that the database has kept."""
    return msgspec.convert(value, StudyConfig)
