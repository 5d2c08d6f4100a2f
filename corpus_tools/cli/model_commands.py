"""The commands that show and train the model."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from corpus_tools.options import (
    FORMAT,
    L2,
    NEGATIVES_SEED,
    OUT,
    PATH,
    WORKERS,
    format_option,
    out_file,
    tell,
    text_argument,
    training_options,
    with_default,
)
from corpus_tools.runtime.terminal import note, say
from g3.errors import SDCError

if TYPE_CHECKING:
    from corpus_tools.runtime.parallel import Workers
    from g3.features.feature_registry import FeatureSet
    from g3.inference.potentials.potential_registry import Potential


@click.command(
    epilog="\b\nExamples:\n"
    '  ct graph "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the truck)))"\n'
    "  ct graph --file put.sdc --format svg --out put.svg\n"
    "  ct graph - --format dot < put.sdc | dot -Tpdf > put.pdf\n"
    '  ct graph "OBJ(f = the truck)" --json'
)
@text_argument("notation")
@click.option("--file", "source", type=PATH, help="Read the notation from a file instead.")
@click.option("--command", "text", help="The command's text, to check the words against it.")
@format_option("dot", "svg", about="A line per factor, JSON, Graphviz, or a picture.")
@OUT
def graph(
    notation: str | None, source: Path | None, text: str | None, form: str, out: Path | None
) -> None:
    """Show the grounding graph of SDCs (section 3.2).

    NOTATION holds clauses as in the paper's Figure 2a, one a line or separated by
    semicolons; "-" reads them from the standard input.
    """
    from corpus_tools.options import as_json
    from g3.graph.graph_drawing import to_dot, to_record, to_svg, to_text
    from g3.graph.grounding_graph import GroundingGraph, grounding_graph
    from g3.sdc.sdc_notation import parse_brackets
    from g3.storage.atomic_file import write_bytes

    try:
        sdcs = parse_brackets(_notation(notation, source), command=text)
    except SDCError as error:
        where = ", ".join(filter(None, (str(source or ""), error.where)))
        raise SDCError(error.what, where=where, fix=error.fix) from error
    if not sdcs:
        raise SDCError("there are no clauses", where=str(source or ""))
    formats: dict[str, Callable[[GroundingGraph], str]] = {
        "text": to_text,
        "json": lambda graph: as_json(to_record(graph)),
        "dot": to_dot,
        "svg": to_svg,
    }
    drawing = formats[form](grounding_graph(sdcs)).rstrip("\n")
    if out is None:
        say(drawing)
    else:
        write_bytes(out, f"{drawing}\n".encode(errors="backslashreplace"))


def _notation(notation: str | None, source: Path | None) -> str:
    if (notation is None) == (source is None):
        raise click.UsageError('Give either NOTATION ("-" for the standard input) or --file.')
    if source is None and notation != "-":
        return notation or ""
    from g3.storage import regular_file
    from g3.storage.text_lines import decode_text

    content = regular_file.read_bytes(source) if source else sys.stdin.buffer.read()
    return decode_text(content, str(source or "standard input"))


@click.group()
def features() -> None:
    """Show the features that the model is made of (3.3).

    \b
    Example:
      ct features list
    """


@features.command("list")
@FORMAT
def list_features(form: str) -> None:
    """List feature sets, and potentials of the search for plans.

    --ablate leaves either out, and --with adds feature sets that are off.

    \b
    Examples:
      ct features list
      ct features list --json
    """
    import g3.inference  # noqa: F401 - fills both catalogues
    from g3.features.feature_registry import CATALOGUE_VERSION, catalogue
    from g3.inference.potentials.potential_registry import KINDS, potentials

    records = [_feature_record(feature) for feature in catalogue()]
    rules = [_potential_record(potential) for potential in potentials()]
    content = {
        "catalogue_version": CATALOGUE_VERSION,
        "feature_sets": records,
        "potentials": rules,
    }
    parts = ["FEATURE SETS, which models are trained with", *map(_feature_text, records)]
    parts.append("POTENTIALS, hand-written rules that the search for plans weighs")
    for kind, about in KINDS.items():
        texts = [_potential_text(record) for record in rules if record["scores"] == kind]
        parts += [f"{kind}: {about}", *texts]
    tell(form, content, "\n\n".join(parts))


def _potential_record(potential: Potential) -> dict[str, object]:
    return {
        "name": potential.name,
        "scores": potential.kind,
        "description": potential.description,
        "types": list(potential.types),
        "roles": list(potential.roles),
        "weight": None if potential.is_hard else round(potential.weight, 4),
        "hard": potential.is_hard,
    }


def _potential_text(record: dict[str, object]) -> str:
    weight = "hard constraint" if record["hard"] else f"{record['weight']:.2f}"
    lines = [
        f"{record['description']}",
        f"SDCs:     {_joined(record['types'])}",
        f"of:       {_joined(record['roles']) or 'the command'}",
        f"weight:   {weight}",
    ]
    return _block(str(record["name"]), lines)


def _block(name: str, lines: list[str]) -> str:
    """Format a name and the lines about it, wrapped."""
    import textwrap

    wrapped = (textwrap.wrap(line, 96, subsequent_indent=" " * 10) for line in lines)
    indented = (f"  {line}" for paragraph in wrapped for line in paragraph)
    return "\n".join([name, *indented])


def _feature_record(feature: FeatureSet) -> dict[str, object]:
    columns = None
    if not callable(feature.columns):
        columns = [
            {"name": c.name, "unit": c.unit, "low": c.low, "high": c.high, "bins": c.bins}
            if c.bins
            else {"name": c.name, "unit": c.unit}
            for c in feature.columns
        ]
    return {
        "name": feature.name,
        "default": feature.default,
        "description": feature.description,
        "types": list(feature.types),
        "optional_types": list(feature.optional),
        "roles": list(feature.roles),
        "words": list(feature.words),
        "alone": feature.alone,
        "scale": feature.scale,
        "columns": columns,
    }


def _feature_text(record: dict[str, object]) -> str:
    columns = record["columns"]
    names = "one for each label or word of the corpus"
    if isinstance(columns, list):
        names = ", ".join(_column_text(column) for column in columns)
    words = _joined(record["words"])
    times = f"the words of {words}" if words else "no words"
    off = "" if record["default"] else "  (off: --with adds it)"
    optional = record["optional_types"]
    extra = f" ({_joined(optional)}: --with adds it)" if optional else ""
    lines = [
        f"{record['description']}",
        f"SDCs:     {_joined(record['types'])}{extra}",
        f"of:       {_joined(record['roles'])}",
        f"times:    {times}{', and alone' if words and record['alone'] else ''}",
        f"features: {names}",
    ]
    return _block(f"{record['name']}{off}", lines)


def _joined(names: object) -> str:
    return ", ".join(map(str, names)) if isinstance(names, list) else ""


def _column_text(column: dict[str, object]) -> str:
    if "bins" not in column:
        return str(column["name"])
    unit = "" if column["unit"] == "1" else f" {column['unit']}"
    limits = f"{column['low']:.3g} to {column['high']:.3g}{unit}"
    return f"{column['name']} ({limits}, {column['bins']} bins)"


@click.group()
def train() -> None:
    """Train models.

    \b
    Example:
      ct train g3 --corpus aaai11 --out g3.npz
    """


@train.command()
@click.option("--corpus", "name", metavar="CORPUS", help="What to train on.")
@click.option(
    "--shards",
    metavar="DIR",
    type=click.Path(path_type=Path, file_okay=False),
    help="Train on what `ct shards` has made instead.",
)
@out_file("The model: NAME.npz, with NAME.json beside.", "MODEL")
@training_options
@NEGATIVES_SEED
@with_default(
    "--optimizer",
    type=click.Choice(["newton", "lbfgs"]),
    default="newton",
    help="How the optimum is found: the paper's way is lbfgs; newton finds the same faster.",
)
@WORKERS
@FORMAT
@click.pass_context
def g3(
    ctx: click.Context,
    *,
    name: str | None,
    shards: Path | None,
    out: Path,
    ablate: tuple[str, ...],
    plus: tuple[str, ...],
    l2: float | None,
    negatives: Literal["random", "hard"],
    seed: int,
    optimizer: Literal["newton", "lbfgs"],
    workers: Workers,
    form: str,
) -> None:
    """Train the grounding model on a corpus (section 3.2).

    Features of more than 20 000 examples are kept in files meanwhile. A corpus that doesn't fit
    into memory is made into shards first, with `ct shards`.

    \b
    Examples:
      ct train g3 --corpus aaai11 --out g3.npz
      ct train g3 --corpus aaai11 --negatives hard --ablate labels --out hard.npz
      ct train g3 --shards shards --jobs 2 --out g3.npz
    """
    from corpus_tools.corpus.labelled_corpus import Options
    from corpus_tools.importers.authored.bundled import open_corpus
    from corpus_tools.learning.trained import from_corpus, from_shards
    from g3.learning.grounding_model import DEFAULT_L2
    from g3.learning.model_file import model_files

    _check_source(ctx, name, shards)
    strength = DEFAULT_L2 if l2 is None else l2
    if shards is not None:
        trained = from_shards(shards, strength, workers, optimizer)
    else:
        options = Options(negatives, seed, ablate, plus)
        trained = from_corpus(open_corpus(name or ""), strength, options, optimizer)
    model = trained.model
    model.save(out)
    if trained.on_disk:
        note("To save memory, features were kept in files, as shards, while training.")
    counts = ", ".join(f"{count} {source}" for source, count in trained.sources.items())
    arrays, card = model_files(out)
    record = {
        "corpus": trained.name,
        "examples": trained.sources,
        "feature_sets": len(model.sets),
        "features": len(model.space_),
        "l2": strength,
        "files": [arrays, card],
    }
    tell(
        form,
        record,
        f"{trained.name}: {sum(trained.sources.values())} examples ({counts})",
        f"{len(model.sets)} feature sets, {len(model.space_)} features, l2 {strength:g}",
        f"wrote {arrays} and {card}",
    )


_OF_CORPORA = ("ablate", "plus", "negatives", "seed")
"""Parameters that `ct shards` has decided."""
_OF_SHARDS = ("jobs", "scheduler")


def _check_source(ctx: click.Context, name: str | None, shards: Path | None) -> None:
    if (name is None) == (shards is None):
        raise click.UsageError("Give either --corpus or --shards.")
    default = click.core.ParameterSource.DEFAULT
    for parameter in ctx.command.params:
        given = ctx.get_parameter_source(parameter.name or "") is not default
        if given and shards is not None and parameter.name in _OF_CORPORA:
            raise click.UsageError(f"{parameter.opts[0]} is an option of `ct shards`.")
        if given and shards is None and parameter.name in _OF_SHARDS:
            raise click.UsageError(
                f"{parameter.opts[0]} goes with --shards; make them with `ct shards`."
            )


_TREES = click.option(
    "--corpus",
    "names",
    metavar="CORPUS",
    required=True,
    multiple=True,
    help="What to train on (repeatable); annotators differ, and the first corpus's are followed.",
)


@train.command()
@_TREES
@out_file("The model, a file.", "MODEL")
@L2
@FORMAT
def parser(*, names: tuple[str, ...], out: Path, l2: float | None, form: str) -> None:
    """Teach the bundled parser a corpus's annotated trees.

    Twenty take seconds. From 100 on the encoder learns, too: 160 take about two minutes. --l2 is
    the strength of the pull towards what the bundled parser knows.

    \b
    Examples:
      ct train parser --corpus mine --out parser.npz
      ct parse "Put the pallet on the truck" --model parser.npz
    """
    from corpus_tools.importers.authored.bundled import open_corpus
    from corpus_tools.learning.trained import parser_from

    corpora = [open_corpus(name) for name in names]
    model = parser_from(corpora, l2)
    model.save(out)
    card = model.card or {}
    tell(
        form,
        {**card, "files": [out]},
        f"corpora {', '.join(c.name for c in corpora)}: {card['commands']} commands, "
        f"l2 {model.l2:g}",
        f"wrote {out} ({out.stat().st_size / 1024:.0f} KiB)",
    )
