"""The formats of others that a corpus can be written in, by name: ``ct corpus export``.

Exporters are named by module and function and loaded when they are used. :func:`register` adds
one. Modules that other distributions name in the entry point group ``ct.exporters`` do so when
this one is imported.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from pkgutil import resolve_name
from typing import TypeAlias, cast

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.runtime.atomic_folder import check_target, write_folder
from g3.errors import FormatError
from g3.registry import Registry

Files: TypeAlias = Mapping[str, bytes | Path]
"""Contents by the files' names in the folder, or the files that hold them."""


@dataclass(frozen=True, slots=True)
class Exporter:
    """A format that a corpus can be written in."""

    name: str
    """Name of the format for ``--to``."""
    summary: str
    """Content of the export, in one line."""
    target: str
    """The function: ``package.module:function``. It gives the files of a corpus."""
    marker: str
    """A file that every folder in this format has. A folder without it isn't replaced."""
    takes_videos: bool = False
    """True if the function also takes ``videos``: folders of ``ct render-videos``, or none."""

    def load(self) -> Callable[..., Files]:
        """Import the function."""
        return cast("Callable[..., Files]", resolve_name(self.target))


EXPORTERS: Registry[Exporter] = Registry("format", "ct.exporters", error=FormatError)
register, exporters = EXPORTERS.add, EXPORTERS.by_name


def export_corpus_to(
    corpus: Corpus, to: str, folder: Path, *, videos: Sequence[Path] = (), force: bool = False
) -> tuple[str, ...]:
    """Write a corpus in another format: the whole folder or, on any error, nothing.

    Parameters
    ----------
    folder
        Target; its parent must be there.
    videos
        Folders of ``ct render-videos`` for the corpus, one for each camera, for formats with
        videos.
    force
        Replace an existing export, if it is in this format.

    Returns
    -------
    tuple of str
        The names of the files.
    """
    exporter = EXPORTERS.known(to, "--to")
    if videos and not exporter.takes_videos:
        raise FormatError(f"the format {to} has no videos", where="--videos", fix="leave it out")
    check_target(folder, force=force, marker=exporter.marker)
    options = {"videos": tuple(videos)} if exporter.takes_videos else {}
    files = exporter.load()(corpus, **options)
    write_folder(folder, files, force=force, marker=exporter.marker)
    return tuple(files)


_HERE = "corpus_tools.exporters"
for _exporter in (
    Exporter(
        "conllu",
        "Universal Dependencies with the clause of each word.",
        f"{_HERE}.treebank_files:conllu_files",
        "corpus.conllu",
    ),
    Exporter(
        "csv",
        "Tables for spreadsheets and pandas: commands, clauses, objects and ratings.",
        f"{_HERE}.csv_tables:csv_files",
        "commands.csv",
    ),
    Exporter(
        "huggingface",
        "Parquet files with a dataset card, for datasets.load_dataset.",
        f"{_HERE}.hugging_face:hugging_face_files",
        "commands.parquet",
    ),
    Exporter(
        "label-studio",
        "Tasks of Label Studio, with the clauses as predictions.",
        f"{_HERE}.label_studio:label_studio_files",
        "label-config.xml",
    ),
    Exporter(
        "lerobot",
        "A LeRobot dataset (v3): an episode for each log, with its language.",
        f"{_HERE}.lerobot_episodes:lerobot_files",
        "meta/info.json",
        takes_videos=True,
    ),
    Exporter(
        "lerobot-2.1",
        "The same in version 2.1, with language in a file of its own.",
        f"{_HERE}.lerobot_episodes:lerobot_2_files",
        "meta/info.json",
        takes_videos=True,
    ),
    Exporter(
        "slu-core",
        "The layout of the AAAI-11 corpus as its authors published it.",
        f"{_HERE}.slu_core:slu_core_files",
        "data/aaai11/forkliftMturkEsdcs.stefie10.groundings.withPaths.yaml.bz2",
    ),
    Exporter(
        "treebank",
        "Commands with their clauses in bracket notation, without worlds.",
        f"{_HERE}.treebank_files:treebank_files",
        "trees.jsonl",
    ),
):
    register(_exporter)

EXPORTERS.load_others()
