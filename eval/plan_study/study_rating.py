"""A study's people: the annotation app's database in its folder, and work offered to a crowd."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from annotation_app.core.config import DATABASE_FILE, Config, open_instance
from annotation_app.crowds.crowd_registry import find_provider, providers
from annotation_app.crowds.crowd_session import open_session
from annotation_app.crowds.publishing import publish_links, publish_posting
from annotation_app.export.corpus_export import find_only_study
from annotation_app.store.database import opened, reading, transaction
from annotation_app.store.schema import migrate
from annotation_app.study_setup.rendered_study import put_study, rendered_videos
from annotation_app.study_setup.study_reading import read_study
from annotation_app.tasks.rate import judgments as ratings
from eval.plan_study.study_plans import ANSWERS, INSTANCE
from g3.annotation import Judgment
from g3.errors import FormatError

MINUTES_EACH = 1


def received(folder: Path) -> Sequence[Judgment]:
    """Return people's ratings so far, from the database in the study's folder."""
    if not (folder / INSTANCE / DATABASE_FILE).exists():
        return ()
    with opened(_instance(folder).database) as engine, reading(engine, one_state=True) as session:
        return ratings(session, find_only_study(session, None))


def offer(
    file: Path,
    platform: str,
    url: str,
    items: int,
    *,
    sandbox: bool = False,
    endpoint: str | None = None,
) -> list[str]:
    """Put a study into the app, and offer as many assignments as its judgments take.

    A repeated offer adds only missing assignments. The result lists the assignments and their
    address.

    The study's file has the pay for a pair, unless only links are made; people reach the app at the
    URL, and an assignment has at most `items` pairs. In the platform's sandbox no money is paid;
    the endpoint is another address of its interface. A FormatError means that there is no such
    platform, nothing is paid, or credentials are missing; a PlatformError that the platform
    refuses.
    """
    provider = find_provider(platform)
    if provider is None:
        names = ", ".join(p.name for p in providers())
        raise FormatError("there is no such platform", where=platform, fix=f"use {names}")
    study = read_study(file)
    if provider.pays and study.payment is None:
        raise FormatError("the study doesn't say what is paid", where=str(file), fix="give --pay")
    config = _instance(file.parent)
    with opened(config.database) as engine:
        migrate(engine)
        with transaction(engine) as session:
            put_study(session, study, rendered_videos(file.parent / study.videos, study.only))
    # Nobody rates a pair twice.
    items = min(items, len(study.pairs))
    people = -(-ANSWERS * len(study.pairs) // items)
    with open_session(
        provider,
        study.name,
        instance=config.instance,
        database=None,
        sandbox=sandbox,
        endpoint=endpoint,
    ) as session:
        if not provider.pays:
            wanted = people if study.access == "invited" else 1  # an open link is for all
            return [*publish_links(session, url=url, task="rate", items=items, people=wanted)]
        posted = publish_posting(
            session,
            url=url,
            task="rate",
            items=items,
            people=people,
            minutes=MINUTES_EACH * items,
            min_approval=0,
            min_approved=0,
        )
    return [f"{posted.added} assignments added, {posted.people} in all", posted.address]


def _instance(folder: Path) -> Config:
    return open_instance(folder / INSTANCE)
