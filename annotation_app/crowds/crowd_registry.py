"""The crowd providers by name. ``ct crowd publish`` and ``ct crowd collect`` have one of each.

They are named by module and object and loaded when they are used. :func:`register` adds one.
Modules that other distributions name in the entry point group ``ct.crowds`` do so when this one is
imported.
"""

from __future__ import annotations

from dataclasses import dataclass
from pkgutil import resolve_name
from typing import TYPE_CHECKING, cast

from g3.registry import Registry

if TYPE_CHECKING:
    from annotation_app.crowds.platform import Gateway


@dataclass(frozen=True, slots=True)
class Provider:
    """A crowd provider, as the command line shows it.

    Parameters
    ----------
    name
        Name in commands and addresses.
    title
        Name for people.
    summary
        Purpose, in one line.
    description
        Further information for users.
    target
        ``package.module:name`` of an :class:`annotation_app.crowds.platform.Gateway`.
    pays
        True if assignments are approved and paid there.
    """

    name: str
    title: str
    summary: str
    description: str
    target: str
    pays: bool = True

    def load(self) -> Gateway:
        """Import what it does."""
        return cast("Gateway", resolve_name(self.target))


PROVIDERS: Registry[Provider] = Registry("crowd provider", "ct.crowds")
register, find_provider, providers = PROVIDERS.add, PROVIDERS.get, PROVIDERS.by_name


register(
    Provider(
        name="links",
        title="Links",
        summary="Links for anybody, or one for each person who is invited.",
        description="People get a completion code at the end. Nothing is paid.",
        target="annotation_app.crowds.links:LINKS",
        pays=False,
    )
)
register(
    Provider(
        name="mturk",
        title="Amazon Mechanical Turk",
        summary="HITs at Amazon Mechanical Turk.",
        description=(
            "Credentials are boto3's: AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or a profile. "
            "The app must be reachable by HTTPS, and allow the platform's frame."
        ),
        target="annotation_app.crowds.mturk:MTURK",
    )
)
register(
    Provider(
        name="prolific",
        title="Prolific",
        summary="A study at Prolific.",
        description=(
            "The token comes from PROLIFIC_TOKEN, the project from PROLIFIC_PROJECT. "
            "--sandbox makes a test run with the workspace's test participants."
        ),
        target="annotation_app.crowds.prolific:PROLIFIC",
    )
)

PROVIDERS.load_others()
