"""How people place the words of a command."""

from __future__ import annotations

from dataclasses import dataclass

from playwright.sync_api import Locator, Page, expect

from tests.annotation_app.pages.test_tasks import tab_to

TREE = [
    {
        "type": "EVENT",
        "f": [{"type": "OBJECT"}],
        "r": [["Go", 0]],
        "l": [
            {
                "type": "PATH",
                "r": [["to", 3]],
                "l": [{"type": "OBJECT", "f": [["the", 6], ["red", 10], ["crate", 14]]}],
            }
        ],
    }
]


def start_from_nothing(page: Page) -> None:
    """There is a suggestion."""
    expect(words_of(page).first).to_be_visible()
    button = page.get_by_role("button", name="start from nothing")
    if button.count():
        button.click()
    expect(page.locator(".places .part")).to_have_count(0)


def words_of(page: Page) -> Locator:
    return page.locator(".word")


def place(page: Page, words: tuple[int, ...], question: str) -> None:
    """Have exactly these words chosen, then choose a place."""
    for i, word in enumerate(words_of(page).all()):
        while (word.get_attribute("aria-pressed") == "true") != (i in words):
            word.click()
    page.locator(".place").filter(has_text=question).first.click()


def make_tree_by_keys(page: Page) -> None:
    """The tree of "Go to the red crate."."""
    if page.locator(".notice button").count():
        tab_to(page, ".notice button")
        page.keyboard.press("Enter")
    tab_to(page, ".word")
    for key in ("Space", "1", "3", "Shift+ArrowRight", "Shift+ArrowRight", "4"):
        page.keyboard.press(key)
    expect(page.locator(".places .part")).to_have_count(3)
    page.keyboard.press("Control+z")
    for key in ("ArrowRight", "Shift+ArrowRight", "1"):
        page.keyboard.press(key)


@dataclass
class Reader:
    """Somebody who does what the page says, word by word, and knows English.

    Parameters
    ----------
    steps
        How often they have pressed something.
    lost
        How often what they looked for wasn't in sight.
    """

    page: Page
    steps: int = 0
    lost: int = 0

    def give(self, said: str, question: str) -> None:
        """Choose words that belong together, and their place."""
        self.choose(said)
        self.answer(question)

    def choose(self, said: str) -> None:
        """Choose words that belong together, as far as they aren't chosen."""
        expect(self.page.locator("#prompt")).not_to_be_empty()
        wanted = said.split()
        for word in words_of(self.page).all():
            if wanted and word.inner_text() == wanted[0] and self._is_free(word):
                wanted.pop(0)
                if word.get_attribute("aria-pressed") != "true":
                    self._press(word)
        expect(self.page.locator("#prompt")).to_contain_text(f"{said} is chosen.")

    def answer(self, question: str) -> None:
        """Give the chosen words the place that asks this."""
        asked = self.page.locator(".place").filter(has_text=question)
        if asked.count() != 1:
            self.lost += 1
        self._press(asked.first)

    def _press(self, what: Locator) -> None:
        self.steps += 1
        what.click()

    def _is_free(self, word: Locator) -> bool:
        return "has a place" not in (word.get_attribute("aria-label") or "")
