"""Commands: parsing, following and filming them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args, overload

from ct.argument_checks import a_kind_of, one_of, positive
from g3.errors import CorpusError

if TYPE_CHECKING:
    from corpus_tools.corpus.corpus_entries import Entry
    from corpus_tools.corpus.corpus_model import Corpus
    from corpus_tools.video.manifest import Settings
    from g3.actions.robot_state import State
    from g3.groundings import Context
    from g3.inference.grounder import Grounder, Result
    from g3.language.parsing.sdc_parser import SDCParser
    from g3.language.parsing.trees import Parse
    from g3.learning.grounding_model import GroundingModel
    from g3.sdc.clauses import SDC

AnyCommand: TypeAlias = "str | Entry | Sequence[SDC] | Parse"
"""A command: its text, an entry of a corpus, its clauses, or a parse."""
Several: TypeAlias = "Corpus | list[str] | list[Entry] | list[Parse]"
"""Several commands."""
Where: TypeAlias = "State | Context | Path | str"
"""A world: a state, a context, a scenario's file or name, or ``CORPUS:CONTEXT``."""


@overload
def parse(
    command: str | Entry, *, n_best: int = ..., extractor: SDCParser | Path | str | None = ...
) -> Parse: ...
@overload
def parse(
    command: Several,
    *,
    n_best: int = ...,
    extractor: SDCParser | Path | str | None = ...,
) -> list[Parse]: ...
def parse(
    command: str | Entry | Several,
    *,
    n_best: int = 1,
    extractor: SDCParser | Path | str | None = None,
) -> Parse | list[Parse]:
    """Extract the clauses of a command (section 3.1), or of each of several.

    Parameters
    ----------
    command
        Text of the command, or an entry of a corpus, which has one; or a list of them, or a corpus.
    n_best
        Largest number of trees.
    extractor
        Parser, or its file; the bundled one if left out.

    Returns
    -------
    Parse
        The trees with their probabilities, best first, which a notebook draws. A list of them for
        several commands.

    Examples
    --------
    >>> ct.parse("Put the pallet on the truck").sdcs
    (SDC('EVENT', 'Put the pallet on the truck'),)
    """
    from corpus_tools.corpus.corpus_entries import Entry
    from corpus_tools.corpus.corpus_model import Corpus
    from g3.language.parsing.parser import parse_many
    from g3.language.parsing.sdc_parser import SDCParser

    used = SDCParser.load(extractor) if isinstance(extractor, (Path, str)) else extractor
    several = isinstance(command, (Corpus, list, tuple))
    commands: list[Any] = list(command) if isinstance(command, (Corpus, list, tuple)) else [command]
    for one in commands:
        a_kind_of("command", one, (str, Entry), "give its text, or an entry of a corpus")
    texts = [one if isinstance(one, str) else one.text for one in commands]
    parses = list(parse_many(texts, n_best=n_best, extractor=used))
    return parses if several else parses[0]


@overload
def follow(
    command: AnyCommand,
    where: Where | None = ...,
    *,
    model: Grounder | GroundingModel | Path | str = ...,
    top: int = ...,
    parses: int = ...,
    explain: bool = ...,
    answers: Mapping[int, str] | None = ...,
    insist: bool = ...,
) -> Result: ...
@overload
def follow(
    command: Several,
    where: Where | None = ...,
    *,
    model: Grounder | GroundingModel | Path | str = ...,
    top: int = ...,
    parses: int = ...,
    explain: bool = ...,
    answers: Mapping[int, str] | None = ...,
    insist: bool = ...,
) -> list[Result]: ...
def follow(
    command: AnyCommand | Several,
    where: Where | None = None,
    *,
    model: Grounder | GroundingModel | Path | str = "warehouse",
    top: int = 1,
    parses: int = 3,
    explain: bool = False,
    answers: Mapping[int, str] | None = None,
    insist: bool = False,
) -> Result | list[Result]:
    """Ground a command in a world and plan its actions (section 3.4). Nothing is carried out.

    Parameters
    ----------
    command
        Text of the command, an entry of a corpus, clauses, or a parse; or a list of texts, entries
        or parses, or a corpus.
    where
        The world. An entry of a corpus has its own.
    model
        A grounder, a model, its file, or its name. The bundled model is trained the first time,
        which takes minutes, and kept.
    top, parses, explain, answers, insist
        As in :meth:`g3.inference.grounder.Grounder.follow`: numbers of plans and trees, reasons,
        answers to questions, and planning where something isn't there.

    Returns
    -------
    Result
        The plans, best first, or why there is none. A plan that the simulated robot can't carry
        out gives the reason (`why_not`). A notebook draws the scene, what the clauses are grounded
        in, and the ways of the plan. A list of them for several commands.

    Raises
    ------
    CorpusError
        If there is no such world or model.

    Examples
    --------
    >>> result = ct.follow("Pick up the boxes", "dock_pick_up_tires")
    >>> result.plan.probability
    """
    from corpus_tools.following.plan_execution import checked
    from g3.inference.grounder import Grounder

    several = _several(command)
    requests: list[tuple[str | Sequence[SDC] | Parse, Where]] = []
    for one in several or [command]:
        words, context = _of_entry(one)
        place = context if where is None else where
        if place is None:
            raise CorpusError(
                "there is no world to follow the command in", fix="give a context or a scenario"
            )
        requests.append((words, place))
    options: dict[str, Any] = {
        "top": top,
        "parses": parses,
        "explain": explain,
        "answers": answers,
        "insist": insist,
    }
    starts = [_state(place) for _, place in requests]
    grounder = model if isinstance(model, Grounder) else _grounder(model)
    results = [
        checked(grounder.follow(words, start, **options))
        for (words, _), start in zip(requests, starts, strict=True)
    ]
    return results[0] if several is None else results


def _several(command: Any) -> list[Any] | None:
    """Return the commands of a list or a corpus; None for one command, also as clauses."""
    from corpus_tools.corpus.corpus_entries import Entry
    from corpus_tools.corpus.corpus_model import Corpus
    from g3.language.parsing.trees import Parse

    if isinstance(command, Corpus):
        return list(command)
    is_list = isinstance(command, Sequence) and not isinstance(command, (str, Parse))
    return (
        list(command)
        if is_list and isinstance(next(iter(command), None), (str, Entry, Parse))
        else None
    )


def _of_entry(command: Any) -> tuple[str | Sequence[SDC] | Parse, Context | None]:
    from corpus_tools.corpus.corpus_entries import Entry
    from g3.language.parsing.trees import Parse
    from g3.sdc.clauses import SDC

    expected = "give its text, an entry of a corpus, clauses, or what ct.parse gave"
    a_kind_of("command", command, (str, Entry, Parse, Sequence), expected)
    if not isinstance(command, (str, Entry, Parse)):
        for clause in command:
            a_kind_of("a clause", clause, (SDC,), expected)
    return (command.text, command.context) if isinstance(command, Entry) else (command, None)


def _state(where: Where) -> State | Context:
    from corpus_tools.following.start_states import context_start, scenario_start
    from g3.actions.robot_state import State
    from g3.groundings import Context

    if not isinstance(where, (Path, str)):
        a_kind_of("where", where, (State, Context), "give a scenario, CORPUS:CONTEXT or a context")
        return where
    is_context = isinstance(where, str) and ":" in where and not Path(where).exists()
    return context_start(str(where)) if is_context else scenario_start(where)


def _grounder(model: GroundingModel | Path | str) -> Grounder:
    from g3.inference.grounder import Grounder

    is_bundled = model == "warehouse" and not Path(model).is_file()
    return _bundled() if is_bundled else Grounder.load(model)


@lru_cache(maxsize=1)
def _bundled() -> Grounder:
    from corpus_tools.following.bundled_grounder import default_model
    from g3.inference.grounder import Grounder

    return Grounder.load(default_model())


def render(
    what: Result | Path | str,
    out: Path | str,
    *,
    camera: Literal["track", "overview", "follow", "operator"] = "track",
    size: tuple[int, int] = (1280, 720),
    fps: int = 25,
    quality: Literal["draft", "standard", "high"] = "standard",
    force: bool = False,
) -> Path:
    """Film a scenario, or the execution of a plan in physics. It needs the extra ``render``.

    Parameters
    ----------
    what
        A scenario's file or name; or a result of :func:`follow`, whose best plan is carried out.
    out
        Of a scenario, a folder, which gets a folder with the video, its log and a picture, as by
        ``ct render-videos``. Of a plan, the video, ``NAME.mp4``; its log comes beside it.
    camera
        All from above; from above, near the action; behind the robot; or from the driver's seat.
    size
        Width and height in pixels, both even.
    fps
        Frames a second.
    quality
        Quality of the drawing.
    force
        Of a scenario: make it again if it is there.

    Returns
    -------
    Path
        The video.

    Raises
    ------
    CorpusError
        If there is no plan, it can't be carried out, a step of it fails (the video shows how), or
        something is missing.
    """
    from corpus_tools.video.drawing.gl import choose_back_end

    choose_back_end()  # before MuJoCo is imported, which reads what this chooses
    from corpus_tools.video.drawing.camera import CAMERAS
    from corpus_tools.video.encode import Quality
    from corpus_tools.video.manifest import Settings
    from g3.inference.grounder import Result

    a_kind_of("what", what, (Result, Path, str), "give a scenario, or what ct.follow gave")
    one_of("camera", camera, CAMERAS)
    one_of("quality", quality, get_args(Quality))
    positive("fps", fps)
    _check_size(size)
    settings = Settings(camera, size, fps, quality)
    if isinstance(what, Result):
        return _film(what, Path(out), settings)
    return _scenario_video(str(what), Path(out), settings, force=force)


def _check_size(size: tuple[int, int]) -> None:
    if len(size) != 2 or any(side < 2 or side % 2 for side in size):
        raise CorpusError(f"size can't be {size}", fix="give width and height, even numbers")


def _scenario_video(name: str, out: Path, settings: Settings, *, force: bool) -> Path:
    from corpus_tools.runtime.parallel import Workers
    from corpus_tools.video.items import scenario_items
    from corpus_tools.video.production import VIDEO, produce_all

    items = scenario_items("warehouse", (name,))
    out.mkdir(parents=True, exist_ok=True)
    (made,) = produce_all(items, out, settings, workers=Workers(), force=force)
    if made.problem:
        raise CorpusError(made.problem, where=name)
    return out / made.name / VIDEO


def _film(result: Result, out: Path, settings: Settings) -> Path:
    from corpus_tools.following.plan_execution import run_plan

    if result.plan is None or result.start is None:
        raise CorpusError("there is no plan to film", where=result.note)
    if out.suffix.lower() != ".mp4":
        raise CorpusError("a video's name ends in .mp4", where=str(out), fix=f"give {out}.mp4")
    if result.plan.why_not:
        raise CorpusError(f"the plan can't be carried out: {result.plan.why_not}")
    done = run_plan(result.start, result.plan.actions, video=out, settings=settings)
    if done.failure is not None:
        raise CorpusError(f"the plan failed: {done.failure}", where=str(out))
    return out
