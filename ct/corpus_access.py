"""Corpora: loading, importing and exporting them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from ct.argument_checks import a_kind_of, known_options, one_of

if TYPE_CHECKING:
    from corpus_tools.corpus.corpus_model import Corpus

AnyCorpus: TypeAlias = "Corpus | Path | str"
"""A corpus, its folder, or the name of a bundled one."""


def load(corpus: AnyCorpus) -> Corpus:
    """Read a corpus.

    Parameters
    ----------
    corpus
        The folder of a corpus, or of the sources of an authored one; or where there is no such
        folder, the name of a bundled corpus, such as ``warehouse``. A corpus is given back.

    Returns
    -------
    Corpus
        Iterating over it gives its commands, each with its annotations and its world.

    Raises
    ------
    FormatError
        If there is none, or something in it is wrong.

    Examples
    --------
    >>> ct.load("warehouse")
    Corpus('warehouse', 28 contexts, 336 commands, 672 annotations)
    """
    from corpus_tools.corpus.corpus_model import Corpus
    from corpus_tools.importers.authored.bundled import open_corpus

    a_kind_of("corpus", corpus, (Corpus, Path, str), "give a corpus, its folder, or its name")
    return corpus if isinstance(corpus, Corpus) else open_corpus(corpus)


def import_corpus(
    format: str,  # noqa: A002 - what it is
    path: Path | str,
    *,
    out: Path | str | None = None,
    force: bool = False,
    keep_going: bool = False,
    salt: str | None = None,
    **options: str,
) -> Corpus:
    """Import a corpus from another format, as ``ct import`` does.

    Parameters
    ----------
    format
        Name of the importer, such as ``slu-core`` (``ct import --help`` lists them).
    path
        File or folder to import.
    out
        A folder to write the corpus to, with a report of the import; nothing is written if
        left out.
    force
        Replace the corpus that is there.
    keep_going
        Leave out the records that can't be read, rather than fail.
    salt
        Secret for the hashes that stand for people; a new one if left out.
    options
        The importer's own, such as ``part="automatic"``.

    Raises
    ------
    CorpusError
        If there is no such importer, or it has no such option.
    FormatError
        If something can't be read.
    """
    import secrets

    from corpus_tools.corpus.corpus_model import Corpus
    from corpus_tools.importers.importer_registry import importers
    from corpus_tools.importers.report import REPORT

    by_name = {importer.name: importer for importer in importers()}
    one_of("format", format, by_name)
    importer = by_name[format]
    choices = {option.name: option.choices for option in importer.options}
    known_options(options, choices, f"import_corpus({format!r})")
    for name, value in options.items():
        one_of(name, value, choices[name] or (value,))
    if out is not None:
        Corpus.check_target(out, force=force)
    given: dict[str, Any] = {option.name: option.default for option in importer.options} | options
    corpus, report = importer.load()(
        Path(path), salt=salt or secrets.token_hex(16), keep_going=keep_going, **given
    )
    if out is not None:
        corpus.save(out, force=force, attachments={REPORT: report.to_bytes()})
    return corpus


def import_slu_core(
    path: Path | str,
    *,
    part: Literal["aaai11", "automatic", "spatial-relations", "all"] = "aaai11",
    heading: str = "loads",
    out: Path | str | None = None,
    force: bool = False,
    keep_going: bool = False,
    salt: str | None = None,
) -> Corpus:
    """Import the corpora that the paper's authors published (h2r/slu_core).

    Parameters
    ----------
    path
        A clone of the repository, its data folder, or a folder with some of its parts.
    part
        The paper's corpus, random tasks without clauses, phrases of paths, or all as one corpus.
    heading
        Which way the robot of random tasks faces: ``loads``, ``things``, degrees from +x, or turned
        from one, such as ``loads+30``.
    out, force, keep_going, salt
        As in :func:`import_corpus`, which raises the same errors.
    """
    options = {"part": part, "heading": heading}
    return import_corpus(
        "slu-core", path, out=out, force=force, keep_going=keep_going, salt=salt, **options
    )


def import_authored(
    path: Path | str,
    *,
    out: Path | str | None = None,
    force: bool = False,
    keep_going: bool = False,
) -> Corpus:
    """Import a corpus whose scenarios and commands are authored in YAML.

    Parameters
    ----------
    path
        A folder with dataset.yaml, scenarios, layouts and logs (docs/authored-corpora.md).
    out, force, keep_going
        As in :func:`import_corpus`, which raises the same errors.
    """
    return import_corpus("authored", path, out=out, force=force, keep_going=keep_going)


def import_treebank(
    path: Path | str,
    *,
    out: Path | str | None = None,
    force: bool = False,
    keep_going: bool = False,
) -> Corpus:
    """Import commands with SDC trees, without worlds and groundings.

    Parameters
    ----------
    path
        A folder with trees.jsonl (docs/treebanks.md).
    out, force, keep_going
        As in :func:`import_corpus`, which raises the same errors.
    """
    return import_corpus("treebank", path, out=out, force=force, keep_going=keep_going)


def export(
    corpus: AnyCorpus,
    out: Path | str,
    *,
    to: str = "corpus",
    videos: Path | str | Sequence[Path | str] | None = None,
    force: bool = False,
) -> Path:
    """Write a corpus to a folder, in this toolkit's format or another project's.

    Parameters
    ----------
    corpus
        Corpus to write.
    out
        The folder; its parent must be there.
    to
        ``corpus``, this toolkit's own format; or one of those that ``ct corpus formats`` lists,
        such as ``huggingface``.
    videos
        Folder of ``ct render-videos`` for the corpus, or several of different cameras, for formats
        with videos.
    force
        Replace an existing export of that format.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    FormatError
        If there is no such format, or the folder holds something else.
    """
    from corpus_tools.exporters.export_registry import export_corpus_to, exporters

    one_of("to", to, ("corpus", *(exporter.name for exporter in exporters())))
    folder = Path(out)
    several = [videos] if isinstance(videos, str | Path) else videos or ()
    films = [Path(video) for video in several]
    if to == "corpus" and not films:
        load(corpus).save(folder, force=force)
    else:
        export_corpus_to(load(corpus), to, folder, videos=films, force=force)
    return folder
