"""The crowd providers by name. ``ct crowd publish`` and ``ct crowd collect`` have one of each.

They are named by module and object and loaded when they are used. :func:`register` adds one.
Modules that other distributions name in the entry point group ``ct.crowds`` do so when this one is
imported.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from g3.extensions import add_member, load_extensions

if TYPE_CHECKING:
    from annotation_app.crowds.platform import Gateway


@dataclass(frozen=True, slots=True)
class Provider:
    """A crowd provider, as the command line shows it.

    Parameters
    ----------
    name
        In commands and addresses.
    title
        What people call it.
    summary
        What it is for, in one line.
    description
        What else a user should know.
    target
        ``package.module:name`` of an :class:`annotation_app.crowds.platform.Gateway`.
    pays
        Whether assignments are approved and paid there.
    """

    name: str
    title: str
    summary: str
    description: str
    target: str
    pays: bool = True

    def load(self) -> Gateway:
        """Import what it does."""
        module, _, name = self.target.partition(":")
        return cast("Gateway", getattr(importlib.import_module(module), name))


_providers: dict[str, Provider] = {}


def register(provider: Provider) -> None:
    """Add a provider; its name must be new."""
    add_member(_providers, provider.name, provider, kind="provider")


def providers() -> tuple[Provider, ...]:
    """All providers, in the order of their names."""
    return tuple(_providers[name] for name in sorted(_providers))


def find_provider(name: str) -> Provider | None:
    """The provider of a name, if there is one."""
    return _providers.get(name)


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

load_extensions("ct.crowds")
