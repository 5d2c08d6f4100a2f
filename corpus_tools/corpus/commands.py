"""``ct corpus``: look at a corpus, count what is in it, check it."""

from __future__ import annotations

from pathlib import Path

import click

from corpus_tools.format_option import FORMAT

CORPUS = click.argument("path", metavar="CORPUS", type=click.Path(path_type=Path))


@click.group()
def corpus() -> None:
    """Look at corpora: what they hold, and whether they are sound.

    \b
    Example:
      ct corpus stats aaai11
    """


@corpus.command()
@CORPUS
@click.argument("id", required=False)
def show(path: Path, id: str | None) -> None:  # noqa: A002 (the argument's name in the help)
    """Show a corpus, or the command, annotation or context with an ID.

    \b
    Examples:
      ct corpus show aaai11
      ct corpus show aaai11 move_tire_pallet-03
      ct corpus show aaai11 move_tire_pallet-03/positive
    """
    from corpus_tools.bundled import open_corpus
    from corpus_tools.corpus import display

    loaded = open_corpus(str(path))
    click.echo(display.overview(loaded) if id is None else display.show(loaded, id))


@corpus.command()
@CORPUS
@FORMAT
def stats(path: Path, form: str) -> None:
    """Count what is in a corpus, beside the figures of the paper's section 4.1.

    \b
    Examples:
      ct corpus stats aaai11
      ct corpus stats aaai11 --format json
    """
    import msgspec

    from corpus_tools.bundled import open_corpus
    from corpus_tools.corpus.display import statistics_table
    from corpus_tools.corpus.statistics import statistics

    counted = statistics(open_corpus(str(path)))
    if form == "json":
        click.echo(msgspec.json.format(msgspec.json.encode(counted), indent=2))
    else:
        click.echo(statistics_table(counted))


@corpus.command()
@CORPUS
@FORMAT
@click.pass_context
def validate(ctx: click.Context, path: Path, form: str) -> None:
    """Check all of a corpus and list every problem.

    The exit status is 0 if it is sound, 1 if it has problems, and 2 if it is no corpus.

    \b
    Examples:
      ct corpus validate aaai11
      ct corpus validate aaai11 --format json
    """
    import json

    from corpus_tools.bundled import resolve
    from corpus_tools.corpus import validation

    problems = validation.validate(resolve(str(path)))
    if form == "json":
        rows = [{"what": p.what, "where": p.where, "fix": p.fix} for p in problems]
        click.echo(json.dumps({"problems": rows}, indent=2))
    else:
        for problem in problems:
            click.echo(str(problem))
        count = len(problems)
        click.echo(f"{path}: {count or 'no'} problem{'' if count == 1 else 's'}")
    if problems:
        ctx.exit(1)
