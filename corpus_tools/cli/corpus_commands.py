"""``ct corpus``: look at a corpus, count what is in it, check it."""

from __future__ import annotations

from pathlib import Path

import click

from corpus_tools.options import FORMAT, PATH, ExistingPath, out_file, tell

CORPUS = click.argument("path", metavar="CORPUS", type=PATH)


@click.group()
def corpus() -> None:
    """Show what corpora hold, and whether they are sound.

    \b
    Example:
      ct corpus stats aaai11
    """


@corpus.command()
@CORPUS
@click.argument("id", required=False)
@FORMAT
def show(path: Path, id: str | None, form: str) -> None:  # noqa: A002 (the argument's name in the help)
    """Show a corpus, or what in it has an ID.

    An ID is that of a command, an annotation, a context or an outcome.

    \b
    Examples:
      ct corpus show aaai11
      ct corpus show aaai11 move_tire_pallet-03
      ct corpus show aaai11 move_tire_pallet-03/positive --json
    """
    from corpus_tools.corpus import display
    from corpus_tools.importers.authored.bundled import open_corpus

    loaded = open_corpus(str(path))
    if id is None:
        tell(form, display.overview_record(loaded), display.overview(loaded))
    else:
        text = display.show(loaded, id)
        tell(form, display.excerpt(loaded, id), text)


@corpus.command()
@CORPUS
@FORMAT
def stats(path: Path, form: str) -> None:
    """Count what is in a corpus, beside the paper's figures (4.1).

    An authored corpus has no such figures beside it.

    \b
    Examples:
      ct corpus stats aaai11
      ct corpus stats aaai11 --json
    """
    from corpus_tools.corpus.corpus_statistics import statistics_of_files
    from corpus_tools.corpus.display import statistics_table
    from corpus_tools.importers.authored.bundled import resolve

    counted = statistics_of_files(resolve(str(path)))
    tell(form, counted, statistics_table(counted))


@corpus.command()
@CORPUS
@FORMAT
@click.pass_context
def validate(ctx: click.Context, path: Path, form: str) -> None:
    """Check all of a corpus and list every problem.

    The exit status is 0 if it is sound, and 2 if it has problems or is no corpus.

    \b
    Examples:
      ct corpus validate aaai11
      ct corpus validate aaai11 --json
    """
    from corpus_tools.corpus import corpus_validation as validation
    from corpus_tools.importers.authored.bundled import resolve

    problems = validation.validate(resolve(str(path)))
    rows = [{"what": p.what, "where": p.where, "fix": p.fix} for p in problems]
    count = f"{len(problems) or 'no'} problem{'' if len(problems) == 1 else 's'}"
    tell(form, {"problems": rows}, *map(str, problems), f"{path}: {count}")
    if problems:
        ctx.exit(2)


@corpus.command()
@CORPUS
@FORMAT
def seal(path: Path, form: str) -> None:
    """Accept changes that you made to a corpus's files by hand.

    A changed corpus is refused, because its digests show that it isn't what was written. This
    checks its records and writes their digests, hash and counts into corpus.json. Models that
    were trained on the corpus know it by its hash; train them again where it has changed.

    \b
    Examples:
      ct corpus seal aaai11
      ct corpus seal aaai11 --json
    """
    from corpus_tools.corpus.corpus_validation import seal as sealed

    before, after = sealed(path)
    record = {"corpus": path, "hash": after.hash, "hash_before": before.hash}
    changed = f"its hash was {before.hash}" if before.hash != after.hash else "its hash is the same"
    tell(form, record, f"sealed {path}: {after.hash}", changed)


@corpus.command()
@FORMAT
def formats(form: str) -> None:
    """List the formats that corpora can be exported in.

    \b
    Examples:
      ct corpus formats
      ct corpus formats --json
    """
    from corpus_tools.exporters.export_registry import exporters
    from corpus_tools.runtime.text_tables import columns

    rows = [{"format": exporter.name, "summary": exporter.summary} for exporter in exporters()]
    tell(form, {"formats": rows}, *columns([tuple(row.values()) for row in rows]))


@corpus.command()
@CORPUS
@click.option("--to", required=True, metavar="FORMAT", help="The format: `ct corpus formats`.")
@out_file("Folder to write.", "DIR")
@click.option(
    "--videos",
    type=ExistingPath(file_okay=False),
    multiple=True,
    help="What `ct render-videos --corpus CORPUS` has made, for the format lerobot; once more for "
    "each further camera.",
)
@click.option("--force", is_flag=True, help="Replace what is there, if it is in this format.")
@FORMAT
def export(
    *, path: Path, to: str, out: Path, videos: tuple[Path, ...], force: bool, form: str
) -> None:
    """Write a corpus in the format of another project.

    docs/exports.md says what goes where. Other distributions can add formats.

    \b
    Examples:
      ct corpus formats
      ct corpus export aaai11 --to huggingface --out aaai11-hf
      ct corpus export warehouse --to conllu --out warehouse-ud
      ct corpus export warehouse --to lerobot --videos films --out warehouse-lerobot
    """
    from corpus_tools.exporters.export_registry import export_corpus_to
    from corpus_tools.importers.authored.bundled import open_corpus

    files = export_corpus_to(open_corpus(str(path)), to, out, videos=videos, force=force)
    record = {"folder": out, "format": to, "files": sorted(files)}
    tell(form, record, f"wrote {out}: {len(files)} files in the format {to}")
