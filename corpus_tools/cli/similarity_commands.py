"""``ct similarity``: how well words fit labels, learned lexicons, and tables of image tags."""

from __future__ import annotations

from pathlib import Path

import click

from corpus_tools.options import FORMAT, PATH, ExistingPath, out_file, tell, with_default
from corpus_tools.runtime.progress import progress_bar
from corpus_tools.runtime.terminal import note

SHOWN_PEOPLE = 5
"""Number of people listed whose commands were mostly unrelated to the execution."""


@click.group()
def similarity() -> None:
    """Learn and show which words name which labels.

    Words are learned from corpora, or from tags of images (section 3.3).

    \b
    Examples:
      ct similarity show skid crate --label pallet --label box
      ct similarity learn automatic warehouse --out words.json
      ct similarity show speaker --lexicon words.json
      ct similarity build tags.txt.bz2 --out tags.npz
    """


@similarity.command(
    epilog="\b\nExamples:\n"
    "  ct similarity build tags.txt --out tags.npz\n"
    "  ct similarity build tags.tsv.bz2 --tags 2000 --out tags.npz\n"
    "  CT_TAGS=tags.npz ct eval table1 --corpus aaai11 --cv scenario"
)
@click.argument("source", metavar="TAGS", type=ExistingPath("give a file of tags"))
@out_file("The table, an .npz file.")
@with_default(
    "--tags",
    "limit",
    type=click.IntRange(2, 20_000),
    default=4000,
    help="How many of the most frequent tags to keep; memory grows with the square of it.",
)
@FORMAT
def build(source: Path, out: Path, limit: int, form: str) -> None:
    """Count which tags occur together in a list of tags per image.

    TAGS has the tags of one image on each line, with commas, tabs or spaces between, and
    may be compressed (.gz, .bz2). It is read twice, a line at a time. Name the table in
    the environment variable CT_TAGS to have the feature set word-tags read it.
    """
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
    "  ct similarity learn automatic --out words.json\n"
    "  ct similarity learn automatic aaai11 warehouse --out words.json\n"
    "  ct similarity show speaker --lexicon words.json"
)
@click.argument("corpora", metavar="CORPORA", nargs=-1, required=True)
@out_file("The lexicon, a JSON file.")
@FORMAT
def learn(corpora: tuple[str, ...], out: Path, form: str) -> None:
    """Learn which words people use for loads, from what was picked up.

    CORPORA have outcomes or annotations. A command counts by how probably it has to do with what
    was done, which differs from person to person. Training and inference learn the same from the
    corpora that they are given, so they don't need this file: it is for looking into.
    """
    from corpus_tools.corpus.load_choices import load_choices
    from corpus_tools.importers.authored.bundled import open_corpus
    from g3.learning.load_choice import LoadChooser

    choices = [choice for name in corpora for choice in load_choices(open_corpus(name))]
    learned = LoadChooser.fit(choices)
    lexicon = learned.lexicon
    lexicon.save(out)
    people = {p: s for p, s in sorted(learned.people.items(), key=lambda x: -x[1]) if p[-1] != "/"}
    most = ", ".join(f"{share:.2f} by {name}" for name, share in [*people.items()][:SHOWN_PEOPLE])
    record = {
        "commands": len(choices),
        "words": len(lexicon.words),
        "names": list(lexicon.names),
        "unrelated": {name: round(share, 3) for name, share in people.items()},
        "files": [out],
    }
    tell(
        form,
        record,
        f"{len(choices)} commands, {len(lexicon.words)} words and pairs of words",
        f"loads: {', '.join(lexicon.names)}",
        "commands unrelated to what was done, the greatest shares: " + (most or "persons unknown"),
        f"wrote {out}; 'ct similarity show WORD --lexicon {out}' shows what it knows",
    )


@similarity.command(
    epilog="\b\nExamples:\n"
    "  ct similarity show skid --label pallet --label truck\n"
    "  ct similarity show wheel 'loading dock' --label tire --label trailer --json\n"
    "  ct similarity show 'red chair' speaker --lexicon words.json"
)
@click.argument("words", nargs=-1, required=True)
@click.option("--label", "labels", multiple=True, help="A label of the map (repeatable).")
@click.option(
    "--lexicon",
    metavar="FILE",
    type=PATH,
    help="Show what `ct similarity learn` has learned instead.",
)
@FORMAT
def show(words: tuple[str, ...], labels: tuple[str, ...], lexicon: Path | None, form: str) -> None:
    """Show each measure's similarity of words and labels, from 0 to 1.

    With --lexicon it shows how much likelier a word makes each kind of load, as a factor. Words
    that go together are in quotes.
    """
    if lexicon is not None:
        _show_learned(words, labels, lexicon, form)
        return
    if not labels:
        raise click.UsageError("Give a --label to compare the words with, or a --lexicon.")
    from rich.text import Text

    from corpus_tools.runtime.text_tables import figure_table, table_lines
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
    table = figure_table(("measure", "word", *labels), words=2)
    for start in range(0, len(records), len(labels)):
        line = records[start : start + len(labels)]
        figures = (f"{r['similarity']:.2f}" for r in line)
        table.add_row(str(line[0]["measure"]), Text(str(line[0]["word"])), *figures)
    tell(form, records, *table_lines(table))


def _show_learned(words: tuple[str, ...], labels: tuple[str, ...], file: Path, form: str) -> None:
    from math import exp

    from g3.language.similarity.learned_lexicon import Lexicon, term_of

    lexicon = Lexicon.load(file)
    records, lines = [], []
    for word in words:
        term = term_of(word)
        log_odds = {name: lexicon.log_odds(term, name) for name in labels or lexicon.names}
        ranked = sorted(log_odds.items(), key=lambda item: (-item[1], item[0]))
        count = lexicon.count(term)
        lines.append(f"{word}: in {count:g} commands")
        for name, odds in ranked:
            records.append(
                {"word": word, "commands": count, "name": name, "log_odds": round(odds, 4)}
            )
            lines.append(f"  {exp(odds):6.2f} times as likely: {name}")
    tell(form, records, *lines)
