"""The studies that ``ct annotate`` serves, put into the installation before it does."""

from __future__ import annotations

from pathlib import Path

from annotation_app.cli.study_commands import show_notes
from annotation_app.core.config import Config
from annotation_app.store.database import opened, transaction
from annotation_app.store.salt import installation_salt
from annotation_app.study_setup.demo_study import demo_study, ready, render_first, render_rest
from annotation_app.study_setup.rendered_study import Rendered, rendered_videos
from annotation_app.study_setup.study_starting import (
    StudyParts,
    prepare_parts,
    put_parts,
    read_parts,
)
from corpus_tools.runtime.progress import progress_bar
from corpus_tools.runtime.terminal import note
from g3.errors import CorpusError
from g3.storage.cache_folder import cache_folder


def demo_instance() -> Path:
    """Return the folder of the demo's installation."""
    return cache_folder() / "annotate-demo"


def put_demo(config: Config, videos: Path | None) -> int:
    """Set the demo up, or bring it up to date; how many of its videos come later."""

    def put_found(found: list[Rendered]) -> None:
        put(config, StudyParts(demo_study(found), found))

    if videos is not None:
        put_found(rendered_videos(videos))
        return 0
    folder = config.instance / "videos"
    render_first(folder)
    put_found(ready(folder))
    return render_rest(folder, put_found)


def put_file(config: Config, file: Path, videos: Path | None = None) -> None:
    """Add the study that a file describes, or update it; an error lists all that is wrong."""
    put(config, read_parts(file, videos))


def bring_up_to_date(config: Config, file: Path) -> None:
    """Bring a study of the folder of studies up to date; a wrong file stops no other."""
    try:
        put_file(config, file)
    except CorpusError as error:
        note(f"note: {error}")
        note(f"note: {file.name} has changed nothing; its study stays as it was")


def put(config: Config, parts: StudyParts) -> None:
    """Add a study to an installation, or bring it up to date."""
    show_notes(parts.notes)
    with progress_bar("looking at the videos") as on_progress:
        ready_videos = prepare_parts(parts, config, on_progress)
    with opened(config.database) as engine:
        salt = installation_salt(engine, config)
        with transaction(engine) as session:
            put_parts(session, parts, ready_videos, salt)
