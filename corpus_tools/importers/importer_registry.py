"""The importers by name. Each becomes a command of ``ct import``.

Importers are named by module and function and loaded when they are used, so that the
command line starts fast. :func:`register` adds one. Modules that other distributions name in
the entry point group ``ct.importers`` do so when this one is imported.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Protocol, cast

from g3.registry import Registry
from g3.short_repr import short_repr

if TYPE_CHECKING:
    from corpus_tools.corpus.corpus_model import Corpus
    from corpus_tools.importers.report import ImportReport
    from corpus_tools.runtime.progress import OnProgress


class ImportFunction(Protocol):
    """Function that imports a corpus."""

    def __call__(
        self,
        path: Path,
        *,
        salt: str,
        keep_going: bool = False,
        on_progress: OnProgress = ...,
        **options: str,
    ) -> tuple[Corpus, ImportReport]:
        """Read what is at `path`.

        Parameters
        ----------
        salt
            Secret that goes into the hashes which stand for people's ids.
        keep_going
            Leave out and report the records that can't be read, rather than fail.
        on_progress
            Called with the progress of the import.
        options
            By name, if the importer has any (:attr:`Importer.options`).
        """


@short_repr
@dataclass(frozen=True, slots=True)
class ImportOption:
    """An option of an importer's command."""

    name: str
    """Keyword of the function."""
    default: str
    summary: str
    choices: tuple[str, ...] = ()
    """Allowed values; any if empty."""
    metavar: str | None = None
    """Placeholder of the value in the help."""


@short_repr
@dataclass(frozen=True, slots=True)
class Importer:
    """An importer, as the command line shows it."""

    name: str
    summary: str
    """Data that are imported, in one line."""
    description: str
    """Form of the path, and other facts that a user should know."""
    target: str
    """The function: ``package.module:function``, an :class:`ImportFunction`."""
    options: tuple[ImportOption, ...] = ()
    examples: tuple[str, ...] = ()
    """Further examples of the command, without ``ct import NAME``."""

    def load(self) -> ImportFunction:
        """Import the function."""
        return cast("ImportFunction", resolve_name(self.target))


IMPORTERS: Registry[Importer] = Registry("importer", "ct.importers")
register, importers = IMPORTERS.add, IMPORTERS.by_name


register(
    Importer(
        name="slu-core",
        summary="The AAAI-11 corpus, as its authors published it (h2r/slu_core).",
        description=(
            "PATH is a clone of the repository h2r/slu_core, its data folder, or a folder with "
            "some of its parts. Files may be compressed with bzip2 or plain. "
            "docs/worlds.md describes the parts beside the paper's corpus."
        ),
        target="corpus_tools.importers.slu_core.slu_corpus:import_parts",
        options=(
            ImportOption(
                "part",
                "aaai11",
                "What to import: the paper's corpus, random tasks without clauses but with what "
                "was done, phrases of paths, or all that is there as one corpus.",
                choices=("aaai11", "automatic", "spatial-relations", "all"),
            ),
            ImportOption(
                "heading",
                "loads",
                "Which way the robot of random tasks faces, which nobody recorded: loads, things, "
                "degrees from +x, or turned from one, such as loads+30.",
                metavar="RULE",
            ),
        ),
        examples=(
            "slu_core --part automatic --out automatic",
            "slu_core --part automatic --heading loads-45 --out turned",
        ),
    )
)

register(
    Importer(
        name="authored",
        summary="A corpus whose scenarios and commands are authored in YAML.",
        description=(
            "PATH is a folder with dataset.yaml, scenarios, layouts and logs, such as "
            "datasets/warehouse. "
            "docs/authored-corpora.md describes the files."
        ),
        target="corpus_tools.importers.authored.authored_corpus:import_authored",
    )
)

register(
    Importer(
        name="treebank",
        summary="Commands with SDC trees, without worlds and groundings.",
        description=(
            "PATH is a folder with trees.jsonl, such as datasets/treebank. "
            "docs/treebanks.md describes the files."
        ),
        target="corpus_tools.importers.treebank:import_treebank",
    )
)

IMPORTERS.load_others()
