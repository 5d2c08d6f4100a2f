"""Which options of ``ct eval`` go together."""

from __future__ import annotations

import click
from click.core import ParameterSource

DESCRIBED = {
    "table": "--table",
    "curve": "--learning-curve",
    "errors": "--errors",
    "sdc": "--sdc",
    "study_folder": "--end-to-end",
    "validity": "--judge-validity",
    "report": "--report",
    "power": "--power",
}
AT_ONCE = ("jobs", "scheduler")
OF_END_TO_END = ("most", "ratings", "crowd", "url", "pay", "items", "sandbox")


def read_mode(ctx: click.Context) -> str:
    """What is to be made."""
    chosen = [name for name in DESCRIBED if is_given(ctx, name)]
    if len(chosen) != 1:
        raise click.UsageError(
            "Give one of --table 1, --table 2, --table 3, --learning-curve, --errors, --sdc, "
            "--end-to-end, --judge-validity, --report and --power."
        )
    table = ctx.params["table"]
    if table not in (None, 1, 2, 3):
        raise click.UsageError(f"The paper has no table {table}; give --table 1, 2 or 3.")
    return chosen[0]


def check_together(ctx: click.Context, mode: str, table: int | None) -> None:
    """Refuse options that don't go together."""
    if mode == "sdc":
        check_sdc_options(ctx)
    elif table == 3:
        check_plan_options(ctx)
    elif mode == "study_folder":
        check_end_to_end_options(ctx)
    elif mode == "report":
        check_report_options(ctx)
    elif mode in ("validity", "power") or table == 2:
        check_study_options(ctx, mode)
    else:
        check_sources(ctx)
        check_options(ctx, mode)


def is_given(ctx: click.Context, name: str) -> bool:
    """Whether somebody gave an option that isn't the same as giving none."""
    if ctx.get_parameter_source(name) in (ParameterSource.DEFAULT, None):
        return False
    return ctx.params.get(name) not in (None, False, "", ())


def check_sources(ctx: click.Context) -> None:
    """Refuse what can't be trained and tested on together."""
    given = {name for name in ("corpus", "train", "test", "model") if is_given(ctx, name)}
    if given not in ({"corpus"}, {"train", "test"}, {"model", "test"}):
        raise click.UsageError(
            "Give --corpus (with --cv scenario or --split scenario), --train and --test, "
            "or --model and --test."
        )
    if given != {"corpus"}:
        _refuse(ctx, ("cv", "split", "test_scenarios"), "divides one --corpus")
    if is_given(ctx, "cv"):
        _refuse(ctx, ("split", "test_scenarios"), "can't go with --cv, which tests all scenarios")
    if "model" in given:
        _refuse(ctx, ("ablate", "plus", "l2"), "is for training, and --model is trained already")


def check_plan_options(ctx: click.Context) -> None:
    """Refuse options that have nothing to do with following commands."""
    if not (is_given(ctx, "train") and is_given(ctx, "test")):
        raise click.UsageError("--table 3 needs --train and --test, which may be the same corpus.")
    if not is_given(ctx, "judge"):
        raise click.UsageError(
            "--table 3 needs --judge automatic; people's ratings are shown by --table 2."
        )
    if ctx.params["form"] in ("csv", "latex"):
        raise click.UsageError("--table 3 has the formats text and json.")
    own = {"table", "train", "test", "cv", "l2", "ablate", "draws", "seed", "form", "out", "judge"}
    own |= set(AT_ONCE)
    others = tuple(str(p.name) for p in ctx.command.params if p.name not in own)
    _refuse(ctx, others, "doesn't go with --table 3")


def check_study_options(ctx: click.Context, mode: str) -> None:
    """Refuse options that have nothing to do with ratings."""
    what = "--table 2" if mode == "table" else DESCRIBED[mode]
    if mode != "power" and not is_given(ctx, "corpus"):
        raise click.UsageError(f"{what} needs a --corpus with ratings.")
    own = {
        "table": {"table", "draws", "study", "models", *AT_ONCE},
        "validity": {"validity", "draws", "study", *AT_ONCE},
        "power": {"power", "half_width"},
    }[mode] | {"corpus", "seed", "form", "out"}
    others = tuple(str(p.name) for p in ctx.command.params if p.name not in own)
    _refuse(ctx, others, f"doesn't go with {what}")
    if mode == "validity" and ctx.params["form"] in ("csv", "latex"):
        raise click.UsageError("--judge-validity has the formats text and json.")


def check_end_to_end_options(ctx: click.Context) -> None:
    """Refuse options that have nothing to do with a study of plans."""
    if not (is_given(ctx, "train") and is_given(ctx, "test")):
        raise click.UsageError("--end-to-end needs --train and --test, which may be the same.")
    if ctx.params["form"] in ("csv", "latex"):
        raise click.UsageError("--end-to-end has the formats text and json.")
    if is_given(ctx, "crowd") != is_given(ctx, "url"):
        raise click.UsageError("--crowd and --url go together.")
    if not is_given(ctx, "crowd"):
        _refuse(ctx, ("pay", "items", "sandbox"), "is for --crowd")
    own = {"study_folder", "most", "ratings", "train", "test", "l2", "draws", "seed", "form", "out"}
    own |= {"crowd", "url", "pay", "items", "sandbox"}
    others = tuple(str(p.name) for p in ctx.command.params if p.name not in own)
    _refuse(ctx, others, "doesn't go with --end-to-end")


def check_report_options(ctx: click.Context) -> None:
    """Refuse options that have nothing to do with reports."""
    if not is_given(ctx, "corpus"):
        raise click.UsageError("--report needs a --corpus; its scenarios are held out in turn.")
    own = {"report", "corpus", "cv", "plans", "videos", "study", "negatives", "l2", "threshold"}
    own |= {"seed", "draws", "top", "repeats", "form"}
    if ctx.params["form"] in ("csv", "latex"):
        raise click.UsageError("--report writes all formats; what is told of it is text or json.")
    others = tuple(str(p.name) for p in ctx.command.params if p.name not in own)
    _refuse(ctx, others, "doesn't go with --report")


def check_options(ctx: click.Context, mode: str) -> None:
    """Refuse options of other modes."""
    _refuse(ctx, ("study", "models"), "is for --table 2")
    _refuse(ctx, ("judge",), "is for --table 3")
    if mode != "table":
        _refuse(ctx, AT_ONCE, "is for --table and --judge-validity")
    _refuse(ctx, ("plans", "videos"), "is for --report")
    _refuse(ctx, OF_END_TO_END, "is for --end-to-end")
    _refuse(ctx, ("half_width",), "is for --power")
    of_mode = {"draws": "table", "repeats": "curve", "top": "errors"}
    for name, its_mode in of_mode.items():
        if mode != its_mode:
            _refuse(ctx, (name,), f"is for {DESCRIBED[its_mode]}")
    if mode == "curve":
        if not ctx.params["repeats"]:
            raise click.UsageError("--learning-curve needs --repeats of 1 or more.")
        _refuse(ctx, ("model",), "can't go with --learning-curve, which trains models")
        if ctx.params["form"] in ("csv", "latex"):
            raise click.UsageError(
                "--format can't go with --learning-curve, which writes a plot and a CSV."
            )
    if mode == "errors" and ctx.params["form"] in ("csv", "latex"):
        raise click.UsageError("--errors has the formats text and json.")


def check_sdc_options(ctx: click.Context) -> None:
    """Refuse options that have nothing to do with the extraction of SDCs."""
    given = {name for name in ("corpus", "train", "test", "model") if is_given(ctx, name)}
    sources = ({"corpus"}, {"corpus", "train"}, {"train", "test"}, {"model", "test"}, {"test"})
    if given not in sources:
        raise click.UsageError(
            "--sdc needs --corpus with --cv scenario, or --test, alone or with --train or --model."
        )
    if ("corpus" in given) != is_given(ctx, "cv"):
        raise click.UsageError("--sdc divides a --corpus with --cv scenario only.")
    if given in ({"model", "test"}, {"test"}):
        _refuse(ctx, ("l2",), "is for training, and the model is trained already")
    others = ("split", "test_scenarios", "negatives", "test_negatives", "ablate", "plus")
    of_studies = ("study", "models", "half_width", "plans", "videos", "judge", *OF_END_TO_END)
    of_tables = ("threshold", "draws", "repeats", "seed", *AT_ONCE)
    _refuse(ctx, (*others, *of_studies, *of_tables), "doesn't go with --sdc")
    if ctx.params["form"] in ("csv", "latex"):
        raise click.UsageError("--sdc has the formats text and json.")


def _refuse(ctx: click.Context, names: tuple[str, ...], why: str) -> None:
    for parameter in ctx.command.params:
        if parameter.name in names and is_given(ctx, parameter.name):
            raise click.UsageError(f"{parameter.opts[0]} {why}.")
