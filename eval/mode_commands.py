"""What ``ct eval`` does for each thing that it makes; imports wait until something is made.

Each function takes the options as they were given, and gives the text to write, or None where it
has written files.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, Protocol

import click

from corpus_tools.format_option import tell
from corpus_tools.progress import progress_bar

if TYPE_CHECKING:
    from corpus_tools.parallel import Team
    from eval.protocol import Choices

Given = Mapping[str, Any]
DRAWS, STUDY_DRAWS = 2000, 10_000
"""Resamples; more of them for Table 2, which has but a few numbers for each."""


class Maker(Protocol):
    """Makes what a mode is for."""

    def __call__(self, given: Given, *, terminal: bool) -> str | None:
        """Give the text to write, or None where files were written."""
        ...


def table_1(given: Given, *, terminal: bool) -> str:
    """Table 1 in one of the formats."""
    from eval import trials
    from eval.correspondence import table_rows
    from eval.formats import render
    from g3.inference.potentials import ablation

    choices = _choices(given)
    rules = ablation(choices.ablate).potentials
    if rules:
        click.echo(
            f"ct: Table 1 makes no plans, so it is the same without {', '.join(sorted(rules))}; "
            "--table 3 shows what potentials are worth",
            err=True,
        )
    draws = given["draws"] or DRAWS
    with _team(given) as team:
        with progress_bar("extracting features") as on_progress:
            result = trials.run(choices, on_progress)
        rows = table_rows(
            result.predictions,
            threshold=choices.threshold,
            draws=draws,
            seed=choices.seed,
            team=team,
        )
    metadata = {"table": 1, **result.metadata, "draws": draws}
    return render(rows, given["form"], metadata, terminal=terminal)


def table_2(given: Given, *, terminal: bool) -> str:
    """Table 2 in one of the formats, from the ratings of a corpus."""
    from corpus_tools.bundled import open_corpus
    from eval.studies.ratings import check_judgments
    from eval.studies.table_2 import render
    from eval.studies.table_2 import table_2 as make

    corpus = open_corpus(given["corpus"])
    check_judgments(corpus.judgments, {command.video for command in corpus.commands.values()})
    drawn = {"seed": given["seed"], "draws": given["draws"] or STUDY_DRAWS}
    of_study = {"study": given["study"], "models": given["models"]}
    with _team(given) as team:
        results = make(corpus.judgments, **of_study, **drawn, team=team)
    metadata = {"table": 2, "corpus": given["corpus"], **drawn}
    return render(results, given["form"], metadata, terminal=terminal)


def table_3(given: Given, *, terminal: bool) -> str | None:
    """Table 3 by the automatic judge, with the judge's validity beside it.

    With a file to write to, scenarios that are done are kept beside it until it is written.
    """
    from corpus_tools import __version__
    from corpus_tools.atomic_file import write_bytes
    from corpus_tools.bundled import open_corpus
    from corpus_tools.parallel import Workers
    from eval.end_to_end import run
    from eval.kept_outcomes import kept_beside
    from eval.plan_report import render
    from eval.studies.judge_report import in_a_line, with_validity
    from eval.studies.judge_validity import known_validity
    from g3.features.registry import CATALOGUE_VERSION

    train, test, seed, out = given["train"], given["test"], given["seed"], given["out"]
    drawn = {"draws": given["draws"] or DRAWS, "seed": seed}
    options = {"l2": given["l2"] or 1.0, "seed": seed, "ablate": sorted(set(given["ablate"]))}
    settings = {
        "corpora": [open_corpus(name).hash for name in (*train.split(","), test)],
        "program": __version__,
        "features": CATALOGUE_VERSION,
        **options,
    }
    kept = kept_beside(out, settings) if out else None
    if kept and kept.scenarios:
        click.echo(f"ct: {len(kept.scenarios)} scenarios are done already: {kept.path}", err=True)
    with progress_bar("reading corpora") as on_progress:
        result = run(
            train,
            test,
            **options,
            done=kept.scenarios if kept else {},
            on_scenario=kept.keep if kept else None,
            workers=Workers(given["jobs"], given["scheduler"]),
            on_progress=on_progress,
        )
    corpora = (open_corpus(name) for name in (test, *train.split(",")))
    validity = known_validity(corpora, **drawn)
    if given["form"] == "json":
        text = with_validity(render(result, "json", **drawn), validity)
    else:
        text = f"{render(result, 'text', **drawn)}\n{in_a_line(validity)}"
    if kept is None:
        return text
    write_bytes(out, f"{text}\n".encode())
    kept.path.unlink(missing_ok=True)
    return None


def judge_validity(given: Given, *, terminal: bool) -> str:
    """Whether the automatic judge says what people say, in one of the formats."""
    from corpus_tools.bundled import open_corpus
    from eval.studies.judge_report import render
    from eval.studies.judge_validity import judge_validity as compare

    drawn = {"seed": given["seed"], "draws": given["draws"] or DRAWS}
    with _team(given) as team:
        found = compare(open_corpus(given["corpus"]), study=given["study"], **drawn, team=team)
    metadata = {"corpus": given["corpus"], **drawn}
    return render(found, _read_or_json(given), metadata, terminal=terminal)


def power(given: Given, *, terminal: bool) -> str:
    """How large a rating study must be."""
    from corpus_tools.bundled import open_corpus
    from eval.studies.plans import assumptions, plans, render

    corpus, half_width, seed = given["corpus"], given["half_width"], given["seed"]
    share, correlation = assumptions(open_corpus(corpus).judgments if corpus else ())
    metadata = {
        "corpus": corpus or "none",
        "wanted_half_width": half_width,
        "share": round(share, 3),
        "correlation": round(correlation, 3),
        "seed": seed,
    }
    rows = plans(half_width, share, correlation, seed)
    return render(rows, given["form"], metadata, terminal=terminal)


def sdc(given: Given, *, terminal: bool) -> str:
    """How well SDC trees are extracted from text."""
    from eval.sdc_report import render
    from eval.sdc_trials import SDCChoices, run

    choices = SDCChoices(*(given[name] for name in ("corpus", "train", "test", "model", "l2")))
    with progress_bar("analysing commands") as on_progress:
        trials, metadata = run(choices, on_progress)
    if metadata.get("seen_scenarios"):
        click.echo(
            "ct: the model was trained on scenarios that are tested; "
            "--corpus with --cv scenario holds them out",
            err=True,
        )
    return render(trials, _read_or_json(given), metadata, top=given["top"], terminal=terminal)


def errors(given: Given, *, terminal: bool) -> str:
    """Examples that score high and low, by type."""
    from eval import trials
    from eval.error_lists import error_lists, render_lists

    choices, top = _choices(given), given["top"]
    with progress_bar("extracting features") as on_progress:
        result = trials.run(choices, on_progress)
    lists = error_lists(result.predictions, result.shown, k=top, threshold=choices.threshold)
    metadata = {**result.metadata, "top": top}
    return render_lists(lists, _read_or_json(given), metadata, terminal=terminal)


def learning_curve(given: Given, *, terminal: bool) -> None:
    """Write the plot of test error by size of training, and the numbers."""
    out: Path | None = given["out"]
    if out is None or out.suffix.lower() not in (".png", ".svg"):
        raise click.UsageError("--learning-curve needs --out FILE.png or FILE.svg.")
    from eval import trials
    from eval.learning_curve import write_csv, write_plot

    repeats = given["repeats"]
    with progress_bar("extracting features") as on_progress:
        points, metadata = trials.curve(_choices(given), repeats, on_progress)
    bounds = f"range of {repeats} random orders"
    write_csv(points, out.with_suffix(".csv"), metadata=metadata)
    write_plot(points, out, metadata=metadata, bounds=bounds)
    files = [out, out.with_suffix(".csv")]
    tell(given["form"], {**metadata, "files": files}, f"wrote {files[0]} and {files[1]}")


def report(given: Given, *, terminal: bool) -> None:
    """Write a report: a page, and the same as JSON, CSV and LaTeX."""
    from eval.report.contents import ReportChoices, gather
    from eval.report.writing import check_writable, write_report

    folder: Path = given["report"]
    check_writable(folder)
    taken = ("corpus", "plans", "videos", "study", "negatives", "l2", "threshold", "seed")
    choices = ReportChoices(
        **{name: given[name] for name in (*taken, "top", "repeats")},
        draws=given["draws"] or DRAWS,
    )
    with progress_bar("extracting features") as on_progress:
        contents = gather(choices, on_progress)
    names = write_report(contents, folder)
    count = f"wrote {len(names)} files to {folder}"
    record = {"folder": folder, "files": list(names)}
    tell(given["form"], record, f"{count}; open {folder / 'report.html'} in a browser")


def end_to_end(given: Given, *, terminal: bool) -> str:
    """Go on with a study of plans, and tell what came of it so far."""
    from corpus_tools.video.gl import choose_back_end

    # Before MuJoCo is imported, which reads what this chooses.
    choose_back_end()
    from eval.plan_study.settings import settings_for
    from eval.plan_study.study import go_on, render

    settings = settings_for(
        given["train"],
        given["test"],
        most=given["most"],
        l2=given["l2"] or 1.0,
        seed=given["seed"],
    )
    with progress_bar("reading corpora") as on_progress:
        study = go_on(
            given["study_folder"],
            settings,
            ratings=given["ratings"],
            pay=given["pay"],
            draws=given["draws"] or DRAWS,
            on_progress=on_progress,
        )
    if given["crowd"]:
        _offer(study.file, given)
    return render(study, _read_or_json(given), terminal=terminal)


def _offer(file: Path, given: Given) -> None:
    """Offer a study's work at a crowd platform."""
    from eval.plan_study.rating import Crowd, offer

    endpoint = os.environ.get("CT_CROWD_ENDPOINT")
    crowd = Crowd(given["crowd"], given["url"], given["items"], given["sandbox"], endpoint)
    for line in offer(file, crowd):
        click.echo(line, err=True)


def table(given: Given, *, terminal: bool) -> str | None:
    """One of the paper's tables."""
    makers: dict[int, Maker] = {1: table_1, 2: table_2, 3: table_3}
    return makers[given["table"]](given, terminal=terminal)


MAKERS: Mapping[str, Maker] = MappingProxyType(
    {
        "table": table,
        "curve": learning_curve,
        "errors": errors,
        "sdc": sdc,
        "study_folder": end_to_end,
        "validity": judge_validity,
        "report": report,
        "power": power,
    }
)
"""By what was asked for."""


def _team(given: Given) -> Team:
    from corpus_tools.parallel import Team, Workers

    return Team(Workers(given["jobs"], given["scheduler"]))


def _choices(given: Given) -> Choices:
    from eval.protocol import Choices

    taken = ("corpus", "train", "test", "model", "test_scenarios", "negatives", "test_negatives")
    others = ("ablate", "plus", "l2", "threshold", "seed")
    return Choices(
        **{name: given[name] for name in (*taken, *others)},
        division="cv" if given["cv"] else "split",
    )


def _read_or_json(given: Given) -> Literal["text", "json"]:
    return "json" if given["form"] == "json" else "text"
