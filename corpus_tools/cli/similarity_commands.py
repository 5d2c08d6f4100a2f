"""``ct similarity``: how well words fit labels, and tables of image tags."""

from __future__ import annotations

from pathlib import Path

import click

from corpus_tools.options.format_option import FORMAT, tell
from corpus_tools.runtime.progress import progress_bar
from corpus_tools.runtime.terminal import note


@click.group()
def similarity() -> None:
    """Show how well words fit labels; build tables of tags.

    The tags are those of images (section 3.3).

    \b
    Examples:
      ct similarity show skid crate --label pallet --label box
      ct similarity build tags.txt.bz2 --out tags.npz
    """


@similarity.command(
    epilog="\b\nExamples:\n"
    "  ct similarity build tags.txt --out tags.npz\n"
    "  ct similarity build tags.tsv.bz2 --tags 2000 --out tags.npz\n"
    "  CT_TAGS=tags.npz ct eval --table 1 --corpus aaai11 --cv scenario"
)
@click.argument("source", metavar="TAGS", type=click.Path(path_type=Path))
@click.option(
    "--out", required=True, type=click.Path(path_type=Path), help="The table, an .npz file."
)
@click.option(
    "--tags",
    "limit",
    type=click.IntRange(2, 20_000),
    default=4000,
    show_default=True,
    help="How many of the most frequent tags to keep; memory grows with the square of it.",
)
@FORMAT
def build(source: Path, out: Path, limit: int, form: str) -> None:
    """Count which tags occur together in a list of tags per image.

    TAGS has the tags of one image on each line, with commas, tabs or spaces between, and
    may be compressed (.gz, .bz2). It is read twice, a line at a time. Name the table in
    the environment variable CT_TAGS to have the feature set word-tags read it.
    """
    if not out.parent.is_dir():
        raise click.UsageError(f"--out: there is no folder {out.parent}; make it first.")
    from corpus_tools.learning.tag_lists import build_table

    with progress_bar("reading") as on_progress:
        table = build_table(source, out, limit=limit, on_progress=on_progress)
    tell(
        form,
        {"images": table.images, "tags": len(table.tags), "files": [out]},
        f"{table.images} images, {len(table.tags)} tags",
        f"wrote {out}; name it in CT_TAGS to use it",
    )


@similarity.command(
    epilog="\b\nExamples:\n"
    "  ct similarity show skid --label pallet --label truck\n"
    "  ct similarity show wheel 'loading dock' --label tire --label trailer --json"
)
@click.argument("words", nargs=-1, required=True)
@click.option(
    "--label", "labels", multiple=True, required=True, help="A label of the map (repeatable)."
)
@FORMAT
def show(words: tuple[str, ...], labels: tuple[str, ...], form: str) -> None:
    """Show each measure's similarity of words and labels, from 0 to 1."""
    from g3.errors import ModelError
    from g3.language.similarity.word_similarity import MEASURES

    records = []
    for name, measure in MEASURES.items():
        try:
            values = measure(words, labels)
        except ModelError as error:
            note(f"note: {name} is off: {error}")
            continue
        records += [
            {"measure": name, "word": word, "label": label, "similarity": round(float(value), 4)}
            for word, row in zip(words, values, strict=True)
            for label, value in zip(labels, row, strict=True)
        ]
    width = max(len("word"), *map(len, words))
    lines = [f"{'measure':10}  {'word':{width}}  " + "  ".join(f"{x:>8}" for x in labels)]
    for start in range(0, len(records), len(labels)):
        line = records[start : start + len(labels)]
        figures = "  ".join(f"{r['similarity']:>{max(8, len(str(r['label'])))}.2f}" for r in line)
        lines.append(f"{line[0]['measure']:10}  {line[0]['word']:{width}}  {figures}")
    tell(form, records, *lines)
