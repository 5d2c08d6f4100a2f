"""Lists of tags per image, of any length, and the tables that are counted from them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from corpus_tools.runtime.progress import OnProgress, no_progress
from g3.errors import FormatError
from g3.language.similarity import cooccurrence
from g3.storage import regular_file
from g3.storage.atomic_file import write_bytes

LINES_PER_REPORT = 10_000


def build_table(
    source: Path, out: Path, *, limit: int, on_progress: OnProgress = no_progress
) -> cooccurrence.TagTable:
    """Count a list of tags and write the table, an .npz file.

    `source` is a text file with the tags of an image on each line, separated by commas, by tabs or
    by spaces; it may be compressed (.gz, .bz2). What follows a # at the start of a line is a
    comment. It is read twice, a line at a time: once for its most frequent tags, once for the pairs
    of these. Memory grows with ``limit``, not with the list. FormatError if it can't be read or has
    no tags.
    """
    tags = cooccurrence.frequent_tags(_images(source, "finding tags", on_progress), limit)
    if not tags:
        raise FormatError(
            "there are no tags",
            where=str(source),
            fix="give the tags of an image on each line, with commas, tabs or spaces between",
        )
    table = cooccurrence.count_together(_images(source, "counting pairs", on_progress), tags)
    write_bytes(out, cooccurrence.table_to_bytes(table))
    return table


def _images(path: Path, step: str, on_progress: OnProgress) -> Iterator[frozenset[str]]:
    try:
        with regular_file.text_of(path) as file:
            for number, line in enumerate(file):
                if number % LINES_PER_REPORT == 0:
                    on_progress(f"{step}, line {number}", 0, 0)
                if line.strip() and not line.startswith("#"):
                    yield cooccurrence.read_tags(line)
    except (OSError, EOFError) as error:
        raise FormatError(
            f"the list can't be read: {error}", where=str(path), fix="check the file"
        ) from error
