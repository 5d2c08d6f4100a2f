"""The corpora that come with the toolkit, built from their sources when they are needed.

A bundled dataset is a folder of ``datasets`` with an authored corpus
(``docs/authored-corpora.md``), a treebank (``docs/treebanks.md``) or simulated ratings of another
one (``docs/simulation.md``). Its corpus is built into the
user's cache when it is first used, and again after its files or the program have changed.
"""

from __future__ import annotations

import contextlib
import hashlib
import secrets
import shutil
import time
from pathlib import Path

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_records import (
    ANNOTATIONS,
    COMMANDS,
    CONTEXTS,
    JUDGMENTS,
    MANIFEST,
    TRAJECTORIES,
)
from corpus_tools.importers.report import REPORT, ImportReport, Journal
from corpus_tools.importers.treebank import import_treebank, is_treebank
from corpus_tools.runtime.shipped import DATASET, bundled, program_digest
from corpus_tools.simulation.simulated_raters import is_rated, rated_corpus, read_raters
from g3.errors import FormatError
from g3.storage.cache_folder import cache_folder

KEPT_DAYS = 30
"""Days for which the builds of an older program are kept: another checkout may use them."""

DIGITS = 16
"""Number of the digest's digits in the name of a build."""

_FILES = (MANIFEST, CONTEXTS, COMMANDS, ANNOTATIONS, JUDGMENTS, TRAJECTORIES)

_BUILDERS = ("corpus", "importers", "logs", "simulation", "world", "../g3")
"""Folders with the modules that determine what is built, from this package."""


def resolve(name_or_path: str | Path) -> Path:
    """Return the folder of a corpus; a bundled one is built first.

    Parameters
    ----------
    name_or_path
        A folder, which is returned as it is; or, where there is no such folder, the name
        of a bundled dataset, such as ``warehouse``. The folder of an authored corpus's
        sources, or of a treebank, stands for the corpus built from it.
    """
    path = Path(name_or_path)
    if path.exists():
        is_source = (path / DATASET).is_file() or is_treebank(path)
        is_source = is_source and not (path / MANIFEST).exists()
        return _built(path) if is_source else path
    source = bundled().get(str(name_or_path))
    if source is None:
        more = "or a folder that `ct import` or `ct annotate export` has made"
        raise FormatError.unknown(
            "folder or bundled corpus", str(name_or_path), bundled(), more=more
        )
    return _built(source)


def open_corpus(name_or_path: str | Path) -> Corpus:
    """Read a corpus, or a bundled one by its name; see :func:`resolve`."""
    return Corpus.load(resolve(name_or_path))


def _built(source: Path) -> Path:
    target = cache_folder() / f"{source.resolve().name}-{_digest(source)}"
    if not _is_whole(target):
        _build(source, target)
    return target


def _is_whole(corpus: Path) -> bool:
    return all((corpus / name).is_file() for name in _FILES)


def _build(source: Path, target: Path) -> None:
    """Build under a temporary name and rename: the first process wins, the others agree."""
    corpus, report = _imported(source)
    new = target.with_name(f".{target.name}.new-{secrets.token_hex(4)}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        corpus.save(new, attachments={REPORT: report.to_bytes()})
        if target.exists() and not _is_whole(target):
            shutil.rmtree(target)  # somebody has removed files from it
        new.rename(target)
    except OSError as error:
        if not _is_whole(target):
            raise FormatError(
                f"the corpus can't be built in the cache: {error.strerror}",
                where=str(target.parent),
                fix="set XDG_CACHE_HOME to a folder that can be written to",
            ) from error
    finally:
        shutil.rmtree(new, ignore_errors=True)
    forget_old(f"{source.resolve().name}-{'?' * DIGITS}", but=target)


def _imported(source: Path) -> tuple[Corpus, ImportReport]:
    if is_rated(source):
        corpus = rated_corpus(source, open_corpus(read_raters(source).corpus))
        counts = {"judgments": len(corpus.judgments)}
        return corpus, Journal(keep_going=False).report("simulated ratings", counts, {})
    if is_treebank(source):
        return import_treebank(source)
    from corpus_tools.importers.authored.authored_corpus import (  # noqa: PLC0415 - once a version only
        import_authored,
    )

    return import_authored(source)


def forget_old(pattern: str, *, but: Path | None = None) -> None:
    """Remove folders from the cache that are older than a month, by a pattern of their names."""
    oldest = time.time() - KEPT_DAYS * 24 * 3600
    for other in cache_folder().glob(pattern):
        with contextlib.suppress(FileNotFoundError):  # another process may be at it
            if other != but and other.stat().st_mtime < oldest:
                shutil.rmtree(other, ignore_errors=True)


def _digest(source: Path) -> str:
    """Digest of a dataset's files and of the program that builds it."""
    digest = hashlib.sha256(program_digest(*_BUILDERS).encode())
    if is_rated(source):
        digest.update(resolve(read_raters(source).corpus).name.encode())
    for path in sorted(p for kind in ("yaml", "mcap", "jsonl") for p in source.rglob(f"*.{kind}")):
        digest.update(f"{path.relative_to(source).as_posix()}\n".encode())
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:DIGITS]
