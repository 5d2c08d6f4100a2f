"""``ct annotate``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from annotation_app.cli.copy_commands import backup, copy_media, restore, verify
from annotation_app.cli.export_commands import export, import_corpus
from annotation_app.cli.installation_commands import INSTALLATION, Place
from annotation_app.cli.people_commands import audit, people
from annotation_app.cli.program_commands import tokens
from annotation_app.cli.study_commands import STUDY_FILES, VIDEOS, check, init
from corpus_tools.options import ExistingPath
from corpus_tools.runtime.terminal import note, say


class _Annotate(click.Group):
    """A group that serves, unless its first argument is a command, or a word that is no file."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if not args or (args[0] not in self.commands and args[0] not in ("-h", "--help")):
            if args and args[0].isalpha() and not Path(args[0]).exists():
                raise click.NoSuchCommand(args[0], possibilities=self.commands, ctx=ctx)
            args = ["serve", *args]
        return super().parse_args(ctx, args)


def _address(_ctx: click.Context, option: click.Parameter, value: str) -> str:
    """Check that links can begin with an address; a usage error otherwise."""
    from urllib.parse import urlsplit

    parts = urlsplit(value)
    is_address = parts.scheme in ("http", "https") and parts.netloc and not parts.query
    if value and not (is_address and not parts.fragment and parts.username is None):
        raise click.UsageError(
            f"{option.opts[0]}: give an address such as https://lab.example.org."
        )
    return value.rstrip("/")


@click.group("annotate", cls=_Annotate)
def annotate() -> None:
    """Run studies: people type, annotate and rate commands.

    They also ground the clauses of commands and check groundings.

    "ct annotate STUDY.yaml" is short for "ct annotate serve STUDY.yaml". "ct annotate"
    alone serves what is in this folder, else a demo on the bundled scenarios.

    \b
    Examples:
      ct annotate
      ct annotate init my-study.yaml
      ct annotate my-study.yaml --port 8080
      ct annotate export my-corpus --study my-study
    """


@annotate.command()
@STUDY_FILES
@click.option(
    "--demo", is_flag=True, help="A study on the bundled scenarios, in a folder of its own."
)
@VIDEOS
@click.option(
    "--studies",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Folder of the studies and videos that admins work with in the browser; made if it isn't "
    "there. Its study files are served [default: studies in the instance].",
)
@INSTALLATION
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen at.")
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=8765,
    show_default=True,
    help="Port to listen at; 0 for any that is free.",
)
@click.option(
    "--threads",
    type=click.IntRange(1, 256),
    default=8,
    show_default=True,
    help="How many requests are answered at the same time.",
)
@click.option("--https", is_flag=True, help="People reach it by HTTPS only, through a proxy.")
@click.option(
    "--url",
    default="",
    metavar="URL",
    callback=_address,
    help="Where people reach it, such as https://lab.example.org: links for them begin with it.",
)
@click.option(
    "--proxies",
    type=click.IntRange(0, 5),
    default=0,
    show_default=True,
    help="How many reverse proxies stand before it.",
)
@click.option(
    "--frame-ancestor",
    "frame_ancestors",
    multiple=True,
    metavar="ORIGIN",
    help="A site that may show it in a frame and gets its forms, such as https://www.mturk.com.",
)
@click.option(
    "--idle-hours",
    type=click.FloatRange(0.1, 24 * 60),
    default=12.0,
    show_default=True,
    help="After how long people with a login who do nothing must sign in again.",
)
@click.option(
    "--limits-storage",
    default="process://",
    show_default=True,
    metavar="URL",
    help="Where several processes count requests together.",
)
@click.option(
    "--media-url",
    default="",
    metavar="URL",
    help="Where the copies are that `ct annotate copy-media` has made, for browsers.",
)
@click.option(
    "--open-trying",
    is_flag=True,
    help="Let anybody try commands, as in the demo, not only people with a login.",
)
@click.option(
    "--model",
    type=ExistingPath(dir_okay=False),
    help="The model that follows tried commands (else the bundled one) and suggests groundings.",
)
def serve(
    *,
    study_files: tuple[Path, ...],
    demo: bool,
    videos: Path | None,
    studies: Path | None,
    place: Place,
    host: str,
    port: int,
    threads: int,
    https: bool,
    frame_ancestors: tuple[str, ...],
    open_trying: bool,
    **settings: Any,
) -> None:
    """Serve studies. New ones are set up first, known ones brought up to date.

    Without STUDY.yaml it serves what is in the database, and the demo where there is none.
    Several processes may serve the same database at different ports. Ctrl-C or SIGTERM ends it
    when the requests that were begun are finished, within 10 seconds; a second one at once. What
    people have sent is safe at any time, and the next start goes on from there.

    \b
    Examples:
      ct annotate serve --demo
      ct annotate serve --studies my-studies
      ct annotate serve my-study.yaml --host 0.0.0.0 --https --proxies 1
      ct annotate serve my-study.yaml --database postgresql://me@localhost/annotation
    """
    from dataclasses import replace

    from annotation_app.cli import served_studies
    from annotation_app.core.config import open_instance
    from annotation_app.serving import server as serving

    is_elsewhere = place.instance != Path("annotation")
    is_new = study_files or studies or is_elsewhere or place.database
    demo = demo or not (is_new or place.instance.exists())
    folder = served_studies.demo_instance() if demo and not is_elsewhere else place.instance
    config = replace(
        open_instance(folder, place.database),
        https=https,
        frame_ancestors=frame_ancestors,
        form_targets=frame_ancestors,
        open_trying=open_trying or demo,
        studies=studies,
        **settings,
    )
    made_here = () if study_files else sorted(config.studies_folder.glob("*.yaml"))
    coming = 0

    def tell_addresses() -> None:
        name = "localhost" if host in ("127.0.0.1", "::1") else host
        at = "" if https else f":{serving.port_of(bound)}"
        base = config.url or f"{'https' if https else 'http'}://{name}{at}"
        for what, address in serving.addresses(config, base):
            say(f"{what}: {address}")
        for obstacle in serving.obstacles(config):
            note(f"note: {obstacle}")
        if coming:
            say(f"{coming} more videos are made meanwhile, and come to the demo one by one")
        say("Open an address in a browser. Ctrl-C ends it; nothing that was sent is lost.")
        if host not in serving.LOOPBACK and not https:
            note("note: without --https passwords and answers can be read on the way")

    # Who finds the port taken has set nothing up, and made no link that replaces another.
    with serving.bound(host, port) as bound:
        serving.prepare(config)
        serving.make_first_admin(config)
        if demo:
            coming = served_studies.put_demo(config, videos)
        for file in study_files:
            served_studies.put_file(config, file, videos)
        for file in made_here:
            served_studies.bring_up_to_date(config, file)
        serving.serve(config, bound, threads=threads, listening=tell_addresses)


for _command in (
    audit,
    backup,
    check,
    copy_media,
    export,
    import_corpus,
    init,
    people,
    restore,
    tokens,
    verify,
):
    annotate.add_command(_command)
