"""Steps and mistakes in two designs of Segment: ``python -m benchmarks.segment_designs``.

Both pages run in Chromium: the one that is here, and the first one, which asked for figures and
landmarks. That one comes from the history of the repository, so a clone with it is needed; else
only the page that is here is counted. A scripted user knows what the words mean. The *literal* one
does what the page says: looks what is chosen, and to which clause it would go. The *hasty* one
presses the words of each clause, then the first button of the right kind.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from playwright.sync_api import Browser, Locator, Page, Route, sync_playwright

from annotation_app.tasks.clause_words import words_of
from g3.sdc.clauses import SDC, Field, Span, breadth_first
from g3.sdc.sdc_notation import from_json, parse_brackets

FLAGS = ["--no-sandbox", "--disable-gpu"]
ROOT = Path(__file__).resolve().parents[1]
FIRST_DESIGN = "8518231c9ade9b92bfa82f5eb9ab22171b333ad7"
"""The last commit that has the first design."""
SENTENCES = {
    "Sail to the buoy by the lighthouse.": (
        "EVENT(r = Sail, l = PATH(r = to, l = OBJ(f = OBJ(f = the buoy), r = by, "
        "l = OBJ(f = the lighthouse))))"
    ),
    "Put the cup on the table": (
        "EVENT(r = Put, l = OBJ(f = the cup), l2 = PLACE(r = on, l = OBJ(f = the table)))"
    ),
    "Take the cup on the table": (
        "EVENT(r = Take, l = OBJ(f = OBJ(f = the cup), r = on, l = OBJ(f = the table)))"
    ),
    "Put it down": "EVENT(r = Put down, l = OBJ(f = it))",
    "Go to the crate and lift the box": (
        "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the crate))); "
        "EVENT(r = lift, l = OBJ(f = the box))"
    ),
    "Drive the box to the truck": (
        "EVENT(r = Drive, l = OBJ(f = the box), l2 = PATH(r = to, l = OBJ(f = the truck)))"
    ),
}
"""What people practise with and read in the instructions, and two more commands."""
KINDS = {"EVENT": "What is done", "OBJECT": "what", "PLACE": "where", "PATH": "which way"}
JOINING = {"and"}
"""Words that have no place."""
FIELDS: dict[Field, str] = {"f": "figure", "l": "landmark", "l2": "second landmark"}
FIELDS_BELOW: tuple[Field, ...] = ("l", "l2")
MADE = """async () => {
  const { toJson } = await import("/static/js/sdc.js");
  const { payload } = JSON.parse(document.getElementById("item").textContent);
  const draft = Object.entries(localStorage).find(([key]) => key.includes(":draft:"));
  return draft ? toJson(JSON.parse(draft[1]).body, payload.words) : [];
}"""
"""What was made so far, as it would be sent."""


@dataclass(frozen=True)
class Part:
    """Words that belong together: a clause, or what describes a thing.

    Parameters
    ----------
    words
        Their numbers in the command.
    of
        The part that they belong to.
    field
        That part's field.
    """

    words: tuple[int, ...]
    type: str
    of: Part | None
    field: Field | None
    describes: bool = False


def parts_of(tree: SDC, numbers: Mapping[int, int]) -> Iterator[Part]:
    """The parts of a tree in the order in which people give them.

    Parameters
    ----------
    numbers
        Of words, by where they start.
    """

    def parts(sdc: SDC, of: Part | None, field: Field | None) -> Iterator[Part]:
        def part(spans: Iterable[Span], above: Part | None, *, describes: bool = False) -> Part:
            found = tuple(numbers[span.start] for span in spans)
            return Part(found, sdc.type, above, None if describes else field, describes)

        if sdc.type == "OBJECT" and sdc.figure:
            yield (thing := part(sdc.figure[0].words, of))
            yield (own := part(sdc.relation, thing, describes=True))
        else:
            yield (own := part((*sdc.words, *sdc.relation), of))
        for name in FIELDS_BELOW:
            for below in sdc.children(name):
                yield from parts(below, own, name)

    return parts(tree, None, None)


@dataclass
class User:
    """Somebody at a page.

    Parameters
    ----------
    steps
        How often they have pressed something.
    unseen
        How often the place that they looked for wasn't there, or was there twice.
    """

    page: Page
    words: tuple[str, ...]
    steps: int = 0
    unseen: int = 0

    def press(self, what: Locator) -> None:
        self.steps += 1
        what.click()

    def word(self, number: int) -> Locator:
        return self.page.locator(".word").nth(number)

    def chosen(self) -> set[int]:
        every = self.page.locator(".word").all()
        return {i for i, one in enumerate(every) if one.get_attribute("aria-pressed") == "true"}

    def choose(self, words: tuple[int, ...]) -> None:
        """Have these words chosen and no others."""
        for number in sorted(self.chosen() ^ set(words)):
            self.press(self.word(number))

    def press_all(self, words: tuple[int, ...]) -> None:
        for number in words:
            self.press(self.word(number))

    def said(self, part: Part) -> str:
        return " ".join(self.words[number] for number in part.words)


def literally_now(user: User, part: Part) -> None:
    """Choose the words, and the one place that asks for them."""
    extra = {user.words[number] for number in user.chosen() - set(part.words)}
    if extra and extra <= JOINING:
        user.press(user.page.get_by_role("button", name="Leave it out"))
    user.choose(part.words)
    asked = question(user, part)
    places = user.page.locator(".place").filter(has_text=re.compile(re.escape(asked), re.I))
    user.unseen += places.count() != 1
    user.press(places.first)


def question(user: User, part: Part) -> str:
    """What the page asks where a part belongs."""
    if part.of is None:
        return "What is done"
    said = user.said(part.of)
    return f"{said}: which one?" if part.describes else f"{said} {KINDS[part.type]}"


def hastily_now(user: User, part: Part) -> None:
    """Press the words, then the first place of the kind."""
    user.press_all(part.words)
    kind = "which one" if part.describes else KINDS[part.type]
    places = user.page.locator(".place").filter(has_text=re.compile(rf"{kind}\b"))
    if places.count():
        user.press(places.first)
    else:
        user.unseen += 1


def literally_first(user: User, part: Part) -> None:
    """Choose the words, look to which clause they would go, and make them a clause."""
    page = user.page
    user.choose(part.words)
    maker = page.locator(".maker")
    if part.of is not None:
        above = user.said(part.of.of) + " " if part.of.describes and part.of.of else ""
        wanted = f"{above}{user.said(part.of)}"
        now = page.locator(".columns h2", has_text="Current clause").locator("q")
        if not (now.count() and _begins(now.inner_text(), wanted)):
            clauses = page.locator(".clauses .clause bdi")
            own = clauses.filter(has_text=re.compile(rf"^{re.escape(user.said(part.of))}$"))
            user.unseen += own.count() != 1
            user.press(own.first)
    if part.describes:
        return user.press(page.get_by_role("button", name="Add chosen words to the relation"))
    name = FIELDS[part.field] if part.field else "alone"
    field = maker.get_by_role("radio", name=name, exact=True)
    if not field.is_checked():
        user.press(field)
    return user.press(maker.locator(f".type-{part.type}"))


def _begins(shown: str, wanted: str) -> bool:
    """Whether a clause that is shown is one with these words, and perhaps others in it."""
    words, left = wanted.split(), iter(shown.split())
    return shown.startswith(words[0]) and all(word in left for word in words)


def hastily_first(user: User, part: Part) -> None:
    """Press the words, then the button of the kind, wherever it goes."""
    user.press_all(part.words)
    if part.describes:
        add = user.page.get_by_role("button", name="Add chosen words to the relation")
        return user.press(add)
    return user.press(user.page.locator(f".maker .type-{part.type}"))


Way = Callable[[User, Part], None]
DESIGNS: dict[str, tuple[str | None, dict[str, Way]]] = {
    "figure, landmark, second landmark (first)": (
        FIRST_DESIGN,
        {"literal": literally_first, "hasty": hastily_first},
    ),
    "places that ask in plain words (now)": (
        None,
        {"literal": literally_now, "hasty": hastily_now},
    ),
}
"""Each design: its commit, and how people use it."""


def clauses(trees: tuple[SDC, ...]) -> Counter[str]:
    """Each clause with the first word of the one that it is in."""

    def lines(sdc: SDC, where: str) -> Iterator[str]:
        words = " ".join(span.text for span in (*sdc.words, *sdc.relation))
        yield f"{where}{sdc.type} {words}"
        within = words.partition(" ")[0]
        for name in FIELDS:
            for below in sdc.children(name):
                if not below.is_implicit:
                    yield from lines(below, f"{within}, {name}: ")

    return Counter(line for tree in trees for line in lines(tree, ""))


def mark(page: Page, address: str, text: str, way: Way) -> tuple[User, int]:
    """Have somebody mark a sentence; they, and how many clauses are wrong."""
    words = tuple(words_of(text))

    def with_sentence(route: Route) -> None:
        reply = route.fetch()
        item = re.search(r'id="item">(.*?)</script>', reply.text(), re.DOTALL)
        if item is None:
            raise ValueError("the page has no item")
        data = json.loads(item[1])
        data["payload"] = {"command": text, "words": words, "suggestion": None}
        shown = json.dumps(data).replace("<", "\\u003c")
        route.fulfill(response=reply, body=reply.text().replace(item[1], shown))

    page.route("**/practice/segment", with_sentence)
    page.goto(f"{address}/practice/segment")
    page.locator(".word").first.wait_for()
    user = User(page, tuple(word["text"] for word in words))
    wanted = parse_brackets(SENTENCES[text], command=text)
    numbers = {word["start"]: number for number, word in enumerate(words)}
    for tree in wanted:
        for part in parts_of(tree, numbers):
            way(user, part)
    missing = clauses(wanted) - clauses(from_json(page.evaluate(MADE)))
    return user, missing.total()


@contextmanager
def served(commit: str | None, folder: Path) -> Iterator[str]:
    """The address of the practice pages of a commit, or of what is here."""
    root = ROOT
    if commit is not None:
        root = folder / "code"
        archive = subprocess.run(
            ["git", "archive", commit],
            cwd=ROOT,
            check=True,
            capture_output=True,
        ).stdout
        with tarfile.open(fileobj=BytesIO(archive)) as tar:
            tar.extractall(root, filter="data")
    server = str(ROOT / "benchmarks" / "practice_server.py")
    with subprocess.Popen(
        [sys.executable, "-P", server, str(folder / "instance")],
        env={**os.environ, "PYTHONPATH": str(root)},
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            if process.stdout is None or not (port := process.stdout.readline().strip()):
                raise RuntimeError("the server didn't start")
            yield f"http://127.0.0.1:{port}"
        finally:
            process.terminate()


def count(browser: Browser, commit: str | None, way: Way) -> dict[str, int]:
    """What one kind of user does with all sentences in one design."""
    found: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder, served(commit, Path(folder)) as address:
        for text in SENTENCES:
            context = browser.new_context(viewport={"width": 1280, "height": 800}, locale="en")
            user, wrong = mark(context.new_page(), address, text, way)
            found.update(presses=user.steps, wrong=wrong, unseen=user.unseen)
            context.close()
    return dict(found)


def has_history() -> bool:
    """Whether the first design's commit is here."""
    asked = ["git", "cat-file", "-e", FIRST_DESIGN]
    return not subprocess.run(asked, cwd=ROOT, check=False, capture_output=True).returncode


def main() -> None:
    """Count, and print a table."""
    argparse.ArgumentParser(description="Count steps and mistakes in Segment.").parse_args()
    total = sum(
        not one.is_implicit
        for text, notation in SENTENCES.items()
        for one in breadth_first(parse_brackets(notation, command=text))
    )
    print(f"{len(SENTENCES)} sentences, {total} clauses")
    print("| design | user | presses | wrong clauses | place not in sight, or twice |")
    print("| --- | --- | ---: | ---: | ---: |")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        for name, (commit, ways) in DESIGNS.items():
            if commit is not None and not has_history():
                print(f"| {name} | its commit isn't in this clone | | | |")
                continue
            for kind, way in ways.items():
                found = count(browser, commit, way)
                print(f"| {name} | {kind} | " + " | ".join(map(str, found.values())) + " |")


if __name__ == "__main__":
    main()
