"""Text files of other programs: their encoding, their lines, and places in them."""

from __future__ import annotations

import codecs

from g3.errors import FormatError

_OTHER_ENCODINGS = (
    ("UTF-32", codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE),
    ("UTF-16", codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE),
)
_AS_UTF8 = "save it as UTF-8; in Excel as “CSV UTF-8”"


def decode_text(content: bytes, where: str) -> str:
    """Return the text of a UTF-8 file, without a byte order mark.

    Parameters
    ----------
    content
        The bytes of the file.
    where
        The file, as errors name it.
    """
    for name, *marks in _OTHER_ENCODINGS:
        if content.startswith(tuple(marks)):
            raise FormatError(f"the file is {name}, not UTF-8", where=where, fix=_AS_UTF8)
    body = content.removeprefix(codecs.BOM_UTF8)
    try:
        text = body.decode()
    except UnicodeDecodeError as error:
        before = body[: error.start].decode()
        line, column = place_in(before, len(before))
        raise FormatError(
            f"byte {len(content) - len(body) + error.start + 1} is not UTF-8",
            where=f"{where}:{line}:{column}",
            fix=_AS_UTF8,
        ) from None
    if "\0" in text:
        at = text.index("\0")
        line, column = place_in(text, at)
        is_utf16 = text.count("\0") > len(text) // 3
        raise FormatError(
            "the file is UTF-16, not UTF-8" if is_utf16 else "the character is a NUL",
            where=f"{where}:{line}:{column}",
            fix=_AS_UTF8 if is_utf16 else "the file is damaged, or no text; restore it",
        )
    return text


def line_end(text: str) -> str:
    """Return what ends the lines of a text: a line feed, or a carriage return if it has no other.

    Unicode's other line ends, such as U+2028 and U+0085, are characters in a line.
    """
    return "\r" if "\r" in text and "\n" not in text else "\n"


def split_lines(text: str) -> list[str]:
    """Return the lines of a text without their ends; a last line may have no end."""
    end = line_end(text)
    lines = text.split(end)
    if lines[-1] == "":
        lines.pop()
    return [line.removesuffix("\r") for line in lines]


def place_in(text: str, offset: int, end: str | None = None) -> tuple[int, int]:
    """Return the line and the column, both from 1, of the character at an offset.

    `end` is what ends the lines, if that is known already.
    """
    end = line_end(text) if end is None else end
    return text.count(end, 0, offset) + 1, offset - text.rfind(end, 0, offset)
