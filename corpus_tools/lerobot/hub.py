"""Datasets of the Hugging Face Hub: fetching one, and writing a copy back.

Nothing is sent or fetched unless a dataset is named for it. The token is huggingface_hub's own, of
``HF_TOKEN`` or of ``hf auth login``; it is never read here, stored or shown. ``HF_ENDPOINT`` names
another server.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from corpus_tools.lerobot.episode_reading import INFO, open_dataset
from corpus_tools.runtime.extras import import_extra
from g3.errors import CorpusError, FormatError

DATASET = "dataset"
MESSAGE = "Add people's language"
REPLACED = ("data/", "meta/", "videos/", "images/")
"""Folders of a dataset whose other files go when a copy is pushed."""
BESIDES = (".gitattributes", "README.md")
"""Files of a repository that is new."""
_PURPOSE = "Datasets are fetched and pushed"
LOG_IN = "log in with `hf auth login`, or set HF_TOKEN to a token that may do so"


@dataclass(frozen=True, slots=True)
class Pushed:
    """The state of a dataset on the hub after a push."""

    repo_id: str
    commit: str
    url: str
    is_new: bool
    """False if the hub had all of it already, so that nothing was written."""


def check_can_push(repo_id: str) -> None:
    """Check what a push needs before any work is done for it.

    Raises
    ------
    FormatError
        If huggingface_hub isn't installed, the name is none of a dataset's, or nobody is logged in.
    """
    hub = _hub()
    _check_name(repo_id)
    if hub.get_token() is None:
        raise FormatError("nobody is logged in", where=repo_id, fix=LOG_IN)


def fetch(repo_id: str) -> Path:
    """Fetch a dataset into huggingface_hub's cache, as far as it isn't there.

    Returns
    -------
    Path
        Its folder, whose name is the commit.

    Raises
    ------
    CorpusError
        If there is no such dataset, or it can't be fetched.
    """
    with _answers(repo_id):
        return Path(_hub().snapshot_download(repo_id, repo_type=DATASET))


def push(folder: Path, repo_id: str) -> Pushed:
    """Write a dataset to the hub in one commit, and put LeRobot's tag of the version on it.

    A dataset that isn't there is made, and is private. Files that the hub has already are neither
    sent nor written again, so that a push that is repeated changes nothing. A commit that somebody
    else made meanwhile isn't overwritten.

    Raises
    ------
    CorpusError
        If the hub holds something else under this name, refuses, or can't be reached.
    """
    hub, version = _hub(), open_dataset(folder).info.codebase_version
    api = hub.HfApi()
    _check_name(repo_id)
    with _answers(repo_id):
        api.create_repo(repo_id, repo_type=DATASET, private=True, exist_ok=True)
        before = api.dataset_info(repo_id).sha
        there = api.list_repo_files(repo_id, repo_type=DATASET, revision=before)
    if INFO not in there and any(name not in BESIDES for name in there):
        raise FormatError(
            f"the hub has something else under this name: there is no {INFO}",
            where=repo_id,
            fix="choose another name",
        )
    files = {
        path.relative_to(folder).as_posix(): path
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
    operations: list[Any] = [hub.CommitOperationAdd(name, path) for name, path in files.items()]
    operations += [
        hub.CommitOperationDelete(name)
        for name in there
        if name.startswith(REPLACED) and name not in files
    ]
    with _answers(repo_id, is_commit=True):
        made = api.create_commit(
            repo_id, operations, commit_message=MESSAGE, repo_type=DATASET, parent_commit=before
        )
    with _answers(repo_id):
        _tag(api, repo_id, version, made.oid)
    return Pushed(repo_id, made.oid, made.commit_url, made.oid != before)


def _check_name(repo_id: str) -> None:
    utilities = import_extra("huggingface_hub.utils", "hub", _PURPOSE)
    with _answers(repo_id):
        utilities.validate_repo_id(repo_id)


def _tag(api: Any, repo_id: str, version: str, commit: str) -> None:
    """Put the version's tag on a commit: LeRobot loads datasets by it."""
    tags = api.list_repo_refs(repo_id, repo_type=DATASET).tags
    of_version = [tag for tag in tags if tag.name == version]
    if any(tag.target_commit == commit for tag in of_version):
        return
    if of_version:
        api.delete_tag(repo_id, tag=version, repo_type=DATASET)
    api.create_tag(repo_id, tag=version, revision=commit, repo_type=DATASET)


def _hub() -> Any:
    return import_extra("huggingface_hub", "hub", _PURPOSE)


@contextmanager
def _answers(repo_id: str, *, is_commit: bool = False) -> Iterator[None]:
    """Turn what the hub refuses, and what goes wrong on the way, into errors for people."""
    errors = import_extra("huggingface_hub.errors", "hub", _PURPOSE)
    try:
        yield
    except CorpusError:
        raise
    except errors.HFValidationError as error:
        what = f"this is no name of a dataset: {error}"
        raise FormatError(what, where=repo_id, fix="give it as OWNER/NAME") from error
    except errors.HfHubHTTPError as error:
        status = error.response.status_code
        fix = {401: LOG_IN, 403: LOG_IN, 404: f"correct the name; if it is private, {LOG_IN}"}
        if is_commit and status in (409, 412):
            what, remedy = "somebody has changed the dataset meanwhile", "look at it, then repeat"
        else:
            lines = str(error).splitlines() or [""]
            what = f"the hub answered with {status}: {lines[0]:.300}"
            remedy = fix.get(status, "try again later: nothing is written twice")
        raise CorpusError(what, where=repo_id, fix=remedy) from error
    # The second is the error of the library by which huggingface_hub connects: httpx, or another.
    except (OSError, errors.HTTPError, ValueError) as error:
        what = f"the hub can't be reached: {str(error).splitlines()[0] if str(error) else error!r}"
        fix_it = "try again later"
        if is_commit:
            fix_it = "repeat the command with --force: if the commit was made, it isn't made again"
        raise CorpusError(f"{what:.400}", where=repo_id, fix=fix_it) from error
