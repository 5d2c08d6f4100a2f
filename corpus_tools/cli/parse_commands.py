"""``ct parse``: from the text of commands to their SDC trees (section 3.1)."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from corpus_tools.options import OUT, PATH, format_option, text_argument, with_default
from corpus_tools.runtime.terminal import note, say
from g3.errors import FormatError

if TYPE_CHECKING:
    from g3.language.parsing.sdc_parser import SDCParser
    from g3.language.parsing.trees import Parse


@click.command(
    epilog="\b\nExamples:\n"
    '  ct parse "Put the pallet on the truck."\n'
    '  ct parse "Go to the pallet on the truck" --n-best 3\n'
    '  ct parse "Put the tire pallet down" --format svg --out put.svg\n'
    "  ct parse --file commands.txt --json\n"
    '  echo "lift the pallet" | ct parse - | ct graph -'
)
@text_argument("text")
@click.option("--file", "source", type=PATH, help="Read commands from a file instead, one a line.")
@format_option(
    "svg",
    "conllu",
    about="The paper's notation, JSON (a line a command), a picture, or words in CoNLL-U.",
)
@with_default(
    "--n-best",
    type=click.IntRange(1, 100),
    default=1,
    help="How many trees to give for each command, the most probable first.",
)
@click.option(
    "--model",
    type=PATH,
    help="A model of `ct train parser`, rather than the bundled one.",
)
@OUT
def parse(
    *,
    text: str | None,
    source: Path | None,
    form: str,
    n_best: int,
    model: Path | None,
    out: Path | None,
) -> None:
    """Extract the SDC trees of commands (section 3.1).

    TEXT is a command; "-" reads commands from the standard input, one a line. What can't be
    parsed, wholly or in part, is named on the standard error.
    """
    from g3.language.parsing.sdc_parser import SDCParser, default_parser
    from g3.storage.atomic_file import write_bytes

    commands = _commands(text, source)
    if form == "svg" and len(commands) != 1:
        raise click.UsageError("--format svg draws one command.")
    if form in ("svg", "conllu") and n_best > 1:
        raise click.UsageError(f"--format {form} shows the best tree only; leave out --n-best.")
    extractor = default_parser() if model is None else SDCParser.load(model)
    written = _write(commands, form, n_best, extractor)
    content = "\n".join(written)
    if out is None:
        say(content.encode(errors="backslashreplace").decode())
    else:
        write_bytes(out, f"{content}\n".encode(errors="backslashreplace"))


def _commands(text: str | None, source: Path | None) -> list[str]:
    if (text is None) == (source is None):
        raise click.UsageError('Give either TEXT ("-" for the standard input) or --file.')
    from g3.lengths import check_length
    from g3.storage import regular_file
    from g3.storage.text_lines import decode_text, split_lines

    if text is not None and text != "-":
        check_length(text, where="TEXT")
        return [text]
    where = str(source) if source else "standard input"
    try:
        content = regular_file.read_bytes(source) if source else sys.stdin.buffer.read()
    except OSError as error:
        raise FormatError(f"the file can't be read: {error.strerror}", where=where) from error
    lines = split_lines(decode_text(content, where))
    for number, line in enumerate(lines, start=1):
        check_length(line, where=f"{where}: line {number}")
    commands = [line for line in lines if line.strip()]
    if not commands:
        raise FormatError("there are no commands", where=where, fix="write one a line")
    return commands


def _write(commands: list[str], form: str, n_best: int, extractor: SDCParser) -> list[str]:
    from g3.language.parsing.conllu import to_conllu
    from g3.language.parsing.spacy_pipeline import analyse
    from g3.sdc.sdc_drawing import to_svg

    if form == "conllu":
        parses = list(extractor.predict_proba(commands))
        numbered = enumerate(zip(analyse(commands), parses, strict=True), start=1)
        texts = [to_conllu(a, p.sdcs, sent_id=str(n)) for n, (a, p) in numbered]
    else:
        parses = list(extractor.predict_proba(commands, n_best=n_best))
        if form == "json":
            texts = [_json(p) for p in parses]
        elif form == "svg":
            texts = [to_svg(p.sdcs) for p in parses]
        else:
            texts = [_brackets(p, n_best, several=len(commands) > 1) for p in parses]
    for number, parsed in enumerate(parses, 1):
        if parsed.note:
            which = f"command {number}: " if len(commands) > 1 else ""
            note(f"ct: {which}{parsed.note}")
    return texts


def _json(parsed: Parse) -> str:
    import json

    from g3.sdc.sdc_notation import to_json

    trees = [{"probability": t.probability, "sdcs": to_json(t.sdcs)} for t in parsed.trees]
    return json.dumps({"text": parsed.text, "note": parsed.note, "trees": trees})


def _brackets(parsed: Parse, n_best: int, *, several: bool) -> str:
    from g3.sdc.sdc_notation import format_brackets

    lines = [f"# {' '.join(parsed.text.split())}"] if several else []
    for tree in parsed.trees:
        lines += [f"# probability {tree.probability:.3f}"] if n_best > 1 else []
        lines.append(format_brackets(tree.sdcs))
    return "\n".join([*lines, ""] if several else lines)
