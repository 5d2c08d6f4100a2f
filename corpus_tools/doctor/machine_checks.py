"""The checks of ``ct doctor`` for everything but the annotation app."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

from corpus_tools.doctor.diagnosis import Remark
from g3.errors import CorpusError
from g3.storage.cache_folder import cache_folder

GIGABYTE = 2**30
NEEDED_BYTES = GIGABYTE
"""Enough for the bundled corpus, its videos and a model."""


def drawing() -> str:
    """Check that pictures can be drawn without a screen."""
    from corpus_tools.video.drawing.gl import VARIABLE, choose_back_end  # noqa: PLC0415 - slow to import

    return f"{VARIABLE}={choose_back_end()}"


def encoding() -> str:
    """Check that videos can be encoded."""
    from corpus_tools.video.drawing.gl import check_packages  # noqa: PLC0415 - slow to import

    check_packages()
    import av  # noqa: PLC0415 - comes with the extra "render"

    from corpus_tools.video.encode import ENCODER  # noqa: PLC0415 - needs av

    if ENCODER not in av.codecs_available:
        raise CorpusError(
            f"this build of PyAV has no {ENCODER}",
            fix="install the wheel: pip install --force-reinstall --only-binary av av",
        )
    return f"{ENCODER} of PyAV {av.__version__}"


def wordnet() -> str:
    """Check that WordNet can be read."""
    from g3.language.similarity import resources  # noqa: PLC0415 - slow to import

    return f"{len(resources.wordnet().senses)} nouns"


def image_tags() -> str:
    """Check that the table of image tags can be read."""
    from g3.language.similarity import resources  # noqa: PLC0415 - slow to import

    table = resources.tag_table()
    return f"{len(table.tags)} tags of {table.images} images"


def parsing() -> str:
    """Check that commands can be parsed."""
    from g3.language.parsing.sdc_parser import default_parser  # noqa: PLC0415 - slow to import
    from g3.language.parsing.spacy_pipeline import language_model  # noqa: PLC0415 - as above

    meta = language_model().meta
    default_parser()
    return f"{meta['lang']}_{meta['name']} {meta['version']}"


def corpora() -> str:
    """Check that the bundled corpora are there, and can be built into the cache."""
    from corpus_tools.runtime.shipped import bundled  # noqa: PLC0415 - keeps the module's import light

    if not bundled():
        raise CorpusError("there is no bundled corpus", fix="install the package again")
    cache = cache_folder()
    if not os.access(_nearest(cache), os.W_OK):
        raise CorpusError(
            "the cache can't be written to",
            where=str(cache),
            fix="make it writable, or set XDG_CACHE_HOME to a folder that is",
        )
    return f"{', '.join(bundled())}; cache in {cache}"


def disk() -> str:
    """Check that there is room for results, for scratch files and for the cache."""
    rooms = []
    for folder in (Path.cwd(), Path(tempfile.gettempdir()), _nearest(cache_folder())):
        free = shutil.disk_usage(folder).free
        if free < NEEDED_BYTES:
            raise CorpusError(
                f"only {free / GIGABYTE:.1f} GiB are free",
                where=str(folder),
                fix="free at least 1 GiB, or work in another folder (TMPDIR for scratch files, "
                "XDG_CACHE_HOME for what is kept)",
            )
        rooms.append(f"{free / GIGABYTE:.0f} GiB free in {folder}")
    return ", ".join(rooms)


def extras() -> str | Remark:
    """List the missing extras. None of them is needed."""
    from corpus_tools.runtime import extras as known  # noqa: PLC0415 - keeps the module's import light

    missing = {extra: lacking for extra in known.extras() if (lacking := known.missing_of(extra))}
    if missing:
        listed = "; ".join(f"{extra} ({', '.join(names)})" for extra, names in missing.items())
        return Remark(
            f"not installed: {listed}",
            f"if you want them: pip install '{known.DISTRIBUTION}[{','.join(missing)}]'",
        )
    return ", ".join(known.extras())


def _nearest(folder: Path) -> Path:
    """Return the folder, or the nearest existing one above it."""
    return next(f for f in (folder, *folder.parents) if f.exists())
