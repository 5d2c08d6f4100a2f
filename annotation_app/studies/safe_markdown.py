"""Markdown of studies as HTML that can do no harm."""

from __future__ import annotations

import functools
import re

from markdown_it import MarkdownIt
from markupsafe import Markup

_NOT_KNOWN = ("html_block", "html_inline", "image", "heading", "lheading", "reference")
_LINK = re.compile(r"(https?://|mailto:)", re.IGNORECASE)


def to_html(text: str) -> Markup:
    """Return a text as HTML that can be put into a page.

    CommonMark is understood, but for what would load something, run something or break the order
    of the page's headings: such text is shown as it was typed.
    """
    return Markup(_parser().render(text))  # noqa: S704 - the parser escapes all text


@functools.cache
def _parser() -> MarkdownIt:
    parser = MarkdownIt("commonmark", {"html": False}).disable(_NOT_KNOWN)
    parser.validateLink = lambda url: bool(_LINK.match(url))  # type: ignore[method-assign]
    return parser
