"""People who know what a command means and do what Segment's page says, word for word."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from playwright.sync_api import Page

from annotation_app.tasks.clause_words import words_of
from g3.sdc.clauses import SDC, Span

QUESTIONS = {
    "what": "{} what?",
    "who does it": "{}: who does it?",
    "where": "{} where?",
    "which way": "{} which way?",
    "which one": "{}: which one?",
    "when or how": "{} when or how?",
    "what happens": "{} what happens?",
}
SAYS = {"OBJECT": "what", "PLACE": "where", "PATH": "which way"}
READ = """() => {
  const all = (selector, read) => [...document.querySelectorAll(selector)].map(read);
  return {
    words: all(".word", one => one.getAttribute("aria-pressed") === "true"),
    left: all(".word", (one, i) => one.classList.contains("left-out") ? i : null),
    parts: all(".places .part", one => ({
      key: one.dataset.key,
      words: one.querySelector("bdi").textContent,
      says: one.querySelector("small").textContent,
      above: one.closest("ul").parentElement.closest("li")?.querySelector(".part").dataset.key}),
    ),
    places: all(".place", one => [one.dataset.key, one.querySelector("bdi").textContent]),
  };
}"""
SEND = """() => {
  document.querySelector("#submit").click();
  return [...document.querySelectorAll("#problems li")].map(one => one.firstChild.textContent);
}"""
NAMED = """named => {
  const words = [...document.querySelectorAll(".word")];
  const alike = words.filter(one => named.includes(one.textContent));
  const dotted = alike.filter(one => one.classList.contains("unsure"));
  return (dotted.length ? dotted : alike).map(one => words.indexOf(one));
}"""
"""The words of a question, those with dots if there are some."""
PRESS = f"""([selector, number]) => {{
  document.querySelectorAll(selector)[number].click();
  return ({READ})();
}}"""
"""Forty commands are pressed in the page itself: what is in sight is for other tests."""
ITEM = "JSON.parse(document.querySelector('#item').textContent).item"
COME = f"""item => document.readyState === "complete"
  && !(document.querySelector("#item") && {ITEM} === item)"""
"""Condition that the next page is there."""
MOST_STEPS = 200


@dataclass(eq=False)
class Part:
    """Words that belong together, what they say, and the part that they belong to."""

    words: tuple[int, ...]
    says: str
    above: Part | None
    is_alone: bool = False
    """True for a thing that says where by itself, as in "crate truck"."""


@dataclass
class Meaning:
    """Meaning of a command to somebody: a tree, as parts in plain words."""

    text: str
    sdcs: Sequence[SDC]
    parts: list[Part] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.spans = [Span(word["start"], word["text"]) for word in words_of(self.text)]
        for sdc in self.sdcs:
            self._add(sdc, "what to do", None)

    def phrase(self, part: Part) -> str:
        return " ".join(self.spans[word].text for word in part.words) or "Do"

    def part_of(self, word: int) -> Part | None:
        return next((part for part in self.parts if word in part.words), None)

    def _add(self, sdc: SDC, says: str, above: Part | None, is_alone: bool = False) -> Part:
        landmarks = (*sdc.landmark1, *sdc.landmark2)
        if sdc.type == "OBJECT" and not sdc.words:
            thing = self._add(sdc.figure[0], says, above, is_alone)
            above, says = thing, "which one"
        elif sdc.type in {"PLACE", "PATH"} and not sdc.relation and len(landmarks) == 1:
            return self._add(landmarks[0], says, above, is_alone=True)
        made = Part(self._numbers(sdc.words or sdc.relation), says, above, is_alone)
        self.parts.append(made)
        for child in sdc.figure if sdc.type == "EVENT" else ():
            if not child.is_implicit:
                self._add(child, "who does it", made)
        for child in landmarks:
            within = "when or how" if says in {"what to do", "what happens"} else "what happens"
            self._add(child, SAYS.get(child.type, within), made)
        return thing if says == "which one" else made

    def _numbers(self, words: Sequence[Span]) -> tuple[int, ...]:
        return tuple(
            number
            for number, span in enumerate(self.spans)
            if any(word.start <= span.start < word.end for word in words)
        )


class Literal:
    """Somebody at Segment's page.

    Parameters
    ----------
    meaning
        What they take the command to mean.
    pressed
        How often they have pressed something.
    """

    def __init__(self, page: Page, meaning: Meaning) -> None:
        self.page = page
        self.meaning = meaning
        self.pressed = 0
        self._seen: Any = None

    def build(self) -> None:
        """Place word by word what the page asks for, and send it."""
        if self.page.locator(".notice button").count():
            self._press(".notice button")  # start from nothing
        self._say_what_to_do()
        self._answer_prompts()
        self._send()

    def accept(self) -> None:
        """Correct what the page asks about; build the tree where it suggests none."""
        if not self.page.locator(".notice").count():
            return self.build()
        self._answer_prompts()
        return self._send()

    def _say_what_to_do(self) -> None:
        done = [part for part in self.meaning.parts if part.says == "what to do"]
        self._place(next((part for part in done if part.words), done[0]))

    def _answer_prompts(self) -> None:
        """Give each word that the page chooses its place, or leave it out."""
        while chosen := [n for n, is_chosen in enumerate(self._read()["words"]) if is_chosen]:
            before = self.pressed
            self._put_right(chosen[0])
            assert self.pressed > before, f"{self.meaning.text}: {self._read()}"

    def _send(self) -> None:
        """Send it; answer what the page asks then, and send it all the same."""
        item = self.page.evaluate(ITEM)
        answered: set[str] = set()
        while asked := self.page.evaluate(SEND):
            new = [question for question in asked if question not in answered]
            if not new:
                self._press("#problems > button")
                break
            answered.add(new[0])
            self._answer(new[0], asked.index(new[0]))
            self._answer_prompts()
        self.page.wait_for_function(COME, arg=item)

    def _answer(self, question: str, number: int) -> None:
        quoted = re.search("“(.*?)”", question)
        if quoted is None or question.startswith("Nothing says"):
            self._say_what_to_do()
        elif question.endswith("Is it a thing?"):
            alone = [self.meaning.phrase(part) for part in self.meaning.parts if part.is_alone]
            if quoted[1] in alone:
                self._press(f"#problems li:nth-child({number + 1}) button")
        else:
            for word in self.page.evaluate(NAMED, quoted[1].split()):
                self._put_right(word)

    def _put_right(self, word: int) -> None:
        part = self.meaning.part_of(word)
        if part is not None:
            self._place(part)
        elif word not in self._read()["left"]:
            self._choose((word,))
            self._press('[data-key="leave"]')

    def _place(self, part: Part) -> None:
        """Give a part's words their place, after those to which they belong."""
        if part.above is not None:
            self._place(part.above)
        if self._row(part) is not None:
            return None
        if not part.words:
            within = next(one for one in self.meaning.parts if one.above is part)
            self._choose(within.words if self._read()["parts"] else ())
            return self._press('[data-key="unsaid"]')
        self._choose(part.words)
        if part.above is None:
            return self._press(".place", self._places("", r"What to do( next)?\?")[0])
        above = self._row(part.above)
        assert above is not None
        asks = re.escape(QUESTIONS[part.says].format(self.meaning.phrase(part.above)))
        if not self._places(above, asks):
            self._press(f'[data-key="{above}"]')
        places = self._places(above, asks)
        assert places, f"{self.meaning.text}: nothing asks {asks}"
        return self._press(".place", places[0])

    def _places(self, above: str, asks: str) -> list[int]:
        """Return the numbers of the places of a part that ask something."""
        return [
            number
            for number, (key, question) in enumerate(self._read()["places"])
            if re.fullmatch(asks, question)
            and key.startswith(f"{above} ".removeprefix("part ").lstrip())
        ]

    def _row(self, part: Part) -> str | None:
        """Return the key of the row that shows a part where it belongs."""
        above = None if part.above is None else self._row(part.above)
        if part.above is not None and above is None:
            return None
        phrase = self.meaning.phrase(part)
        rows = [
            row["key"]
            for row in self._read()["parts"]
            if (row["words"], row["says"], row.get("above")) == (phrase, part.says, above)
        ]
        alike = [
            one
            for one in self.meaning.parts
            if (self.meaning.phrase(one), one.says, one.above) == (phrase, part.says, part.above)
        ]
        number = alike.index(part)
        return rows[number] if number < len(rows) else None

    def _choose(self, words: Sequence[int]) -> None:
        """Have these words chosen, and no others."""
        while wrong := [
            n for n, is_so in enumerate(self._read()["words"]) if is_so != (n in words)
        ]:
            self._press(".word", wrong[0])

    def _press(self, selector: str, number: int = 0) -> None:
        self.pressed += 1
        assert self.pressed < MOST_STEPS, self.meaning.text
        self._seen = self.page.evaluate(PRESS, [selector, number])

    def _read(self) -> Any:
        """Return what is on the page, as it was after the last press."""
        self._seen = self._seen or self.page.evaluate(READ)
        return self._seen
