"""The commands that show and train the model."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import click

from g3.errors import FormatError, SDCError


@click.command(
    epilog="\b\nExamples:\n"
    '  ct graph "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck)))"\n'
    "  ct graph --file put.sdc --format svg --out put.svg\n"
    "  ct graph - --format dot < put.sdc | dot -Tpdf > put.pdf"
)
@click.argument("notation", required=False)
@click.option(
    "--file",
    "source",
    type=click.Path(path_type=Path),
    help="Read the notation from a file instead.",
)
@click.option("--command", "text", help="The command's text, to check the words against it.")
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "dot", "svg"]),
    default="text",
    show_default=True,
    help="A line per factor, Graphviz, or a picture.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="Write to a file instead of the standard output.",
)
def graph(
    notation: str | None, source: Path | None, text: str | None, form: str, out: Path | None
) -> None:
    """Show the grounding graph of SDCs (section 3.2).

    NOTATION holds clauses as in the paper's Figure 2a, one a line or separated by
    semicolons; "-" reads them from the standard input.
    """
    from corpus_tools.atomic_file import write_bytes
    from g3.graph import GroundingGraph, grounding_graph
    from g3.graph_drawing import to_dot, to_svg, to_text
    from g3.sdc_notation import parse_brackets

    try:
        sdcs = parse_brackets(_notation(notation, source), command=text)
    except SDCError as error:
        where = ", ".join(filter(None, (str(source or ""), error.where)))
        raise SDCError(error.what, where=where, fix=error.fix) from error
    if not sdcs:
        raise SDCError("there are no clauses", where=str(source or ""))
    formats: dict[str, Callable[[GroundingGraph], str]] = {
        "text": to_text,
        "dot": to_dot,
        "svg": to_svg,
    }
    drawing = formats[form](grounding_graph(sdcs)).rstrip("\n")
    if out is None:
        click.echo(drawing)
    else:
        write_bytes(out, f"{drawing}\n".encode(errors="backslashreplace"))


def _notation(notation: str | None, source: Path | None) -> str:
    if (notation is None) == (source is None):
        raise click.UsageError('Give either NOTATION ("-" for the standard input) or --file.')
    if source is None and notation != "-":
        return notation or ""
    content = source.read_bytes() if source else sys.stdin.buffer.read()
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError(
            f"byte {error.start + 1} is not UTF-8",
            where=str(source or "standard input"),
            fix="save the notation as UTF-8",
        ) from None
