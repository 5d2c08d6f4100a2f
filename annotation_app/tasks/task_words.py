"""What tasks are called, and what people are told about them.

Nothing here names an object or an action of any video: what people read, they write.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from annotation_app.store.models import Task


@dataclass(frozen=True, slots=True)
class TaskWords:
    """A task in words: its title, one line about it, and its instructions."""

    title: str
    summary: str
    instructions: tuple[str, ...]


TASK_WORDS: Mapping[Task, TaskWords] = {
    "describe": TaskWords(
        "Describe",
        "Watch a video and type the command that it fulfils.",
        (
            "Watch the video to its end. You may watch it again as often as you like.",
            "Imagine that you had told an expert operator to do exactly this. Type the command "
            "that you would have given, in your own words, in English.",
            "Say what is to be done, not what you see: the operator hears you before anything "
            "has happened, and sees the same scene.",
            "Write as you would speak. There is no single right answer.",
        ),
    ),
    "segment": TaskWords(
        "Segment",
        "Mark the parts of a command and how they belong together.",
        (
            "A command is made of clauses. An EVENT is something to be done (“Put”), an OBJECT a "
            "thing (“the cup”), a PLACE where something is (“on”), a PATH which way something "
            "goes (“to”).",
            "Begin with the EVENT: choose its words, then press EVENT. Go on with the clauses "
            "inside it, each with its own words, and then with those inside them. The program "
            "proposes where each clause belongs; the tree shows it.",
            "Words need not stand side by side: in “Put it down”, the EVENT is “Put … down”.",
            "A clause is the figure (who or what it is about), the landmark or the second "
            "landmark of the clause that it is in, as the picture shows.",
            "An OBJECT may be described by another one: “the cup on the table”. Choose the "
            "clause “the cup”, give it the relation “on”, and add “the table” as its landmark.",
        ),
    ),
    "ground": TaskWords(
        "Ground",
        "Show what the parts of a command refer to.",
        (
            "Go through the clauses one by one. Click the thing that the words refer to, in the "
            "picture or on the map seen from above. Choose several if the words mean several.",
            "Several clauses may mean the same thing: “the cup” and “the cup on the table” are "
            "one cup.",
            "If the words mean a place, choose one that is on the map, or mark it there.",
            "The video tells what the command was meant to bring about.",
            "Where words say what happens, you need do nothing, unless they say only a part of "
            "it: then choose which.",
            "Choose “can't tell” if you have looked and still don't know.",
        ),
    ),
    "check": TaskWords(
        "Check",
        "Tell whether parts of a command match what is shown.",
        (
            "For each clause something is shown that was drawn at random. It need not be what the "
            "command was about, and mostly it isn't.",
            "Choose “It matches” if the words of this clause could well mean what is shown, "
            "looking at nothing but these words.",
            "Choose “It doesn't match” if nobody would mean this by the words.",
        ),
    ),
    "rate": TaskWords(
        "Rate",
        "Watch a video and tell how well a command fits it.",
        (
            "Read the command, then watch the video to its end.",
            "Tell how much you agree with the statement below it. Trust your own judgment.",
            "Some commands fit well and some don't fit at all.",
        ),
    ),
}

KEYS: Mapping[Task, tuple[tuple[str, str], ...]] = {
    "describe": (("Ctrl Enter", "send"),),
    "segment": (
        ("← →", "go from word to word"),
        ("Space", "choose the word, or not"),
        ("Shift ← →", "choose words in a row"),
        ("E O P T", "make an EVENT, OBJECT, PLACE or PATH of the chosen words"),
        ("R F", "add the chosen words to the clause's relation or figure"),
        ("L M S", "next clause becomes landmark, second landmark or figure"),
        ("N", "next clause stands alone"),
        ("[ ]", "go from clause to clause"),
        ("Delete", "remove the clause"),
        ("Ctrl Z, Ctrl Y", "undo, redo"),
        ("Ctrl Enter", "send"),
    ),
    "ground": (
        ("1 to 9", "choose a thing by its number, or not"),
        ("[ ]", "go from clause to clause"),
        ("X", "can't tell"),
        ("M", "mark a place: arrows move, + and − size, Enter sets, Esc ends"),
        ("Ctrl Z, Ctrl Y", "undo, redo"),
        ("Ctrl Enter", "send"),
    ),
    "check": (
        ("Y N X", "it matches, it doesn't, can't tell"),
        ("[ ]", "go from clause to clause"),
        ("Ctrl Z, Ctrl Y", "undo, redo"),
        ("Ctrl Enter", "send"),
    ),
    "rate": (("1 to 5", "choose"), ("Ctrl Enter", "send")),
}
"""What each task's keys do."""

STATEMENT = "The forklift in the video is executing the above spoken command"
LIKERT = ("Strongly disagree", "Disagree", "Neither agree nor disagree", "Agree", "Strongly agree")
"""What raters agree with, and how much; from 1 to 5."""
