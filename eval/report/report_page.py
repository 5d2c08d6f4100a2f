"""A report as one HTML page that needs nothing else."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from importlib.resources import files
from importlib.util import find_spec

from eval.judging.judge_agreement import Agreement
from eval.judging.judge_report import GROUPS, notes
from eval.judging.judge_validity import VERDICTS, Validity
from eval.report.charts import Bar, differences, intervals, reliability
from eval.report.plan_results import WHOLE, Compared, PlanRow, Plans
from eval.report.reliability import calibration_error
from eval.report.report_contents import Contents
from eval.table_1.correspondence import PAPER_TABLE_1, Row
from eval.table_2.rating_table import PAPER as PAPER_TABLE_2
from eval.table_2.rating_table import Results
from eval.table_2.rating_table import notes as table_2_notes
from eval.table_3.plan_report import HEADINGS, TITLES
from eval.table_3.plan_report import PAPER as PAPER_TABLE_3
from eval.tables.comparison_report import shown_p
from eval.tables.formats import interval
from g3.errors import CorpusError

NAMES = {
    "random": "random cost",
    "nearest": "no model: the nearest load",
    "keywords": "no model: keywords",
    "embeddings": "no model: word embeddings",
    "gold-top30": "annotated SDCs, top 30",
    "auto-top30": "extracted SDCs, top 30",
    "gold-all": "annotated SDCs, all",
    "auto-all": "extracted SDCs, all",
    "right": "known right pairs",
    "wrong": "known wrong pairs",
}
WRONG_PLANS = 25


def check_installed() -> None:
    """Refuse to begin what can't be finished.

    Raises
    ------
    CorpusError
        If the package that fills templates isn't installed.
    """
    if find_spec("jinja2") is None:
        raise CorpusError("reports need jinja2", fix="pip install 'corpus-tools-g3[study]'")


def page(contents: Contents) -> str:
    """The page."""
    from jinja2 import Environment, StrictUndefined  # noqa: PLC0415 - an extra
    from markupsafe import Markup  # noqa: PLC0415 - comes with it

    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {
        "f2": _two,
        "f3": _three,
        "signed": _signed,
        "count": _count,
        "to": _to,
        "signed_to": _signed_to,
        "p": shown_p,
    }
    template = environment.from_string(
        files("eval.report").joinpath("page.html").read_text(encoding="utf-8")
    )
    charts = {name: Markup(svg) for name, svg in _charts(contents).items()}  # noqa: S704 - ours
    return template.render(
        contents=contents,
        charts=charts,
        paper_1=PAPER_TABLE_1,
        paper_2=PAPER_TABLE_2,
        paper_3=PAPER_TABLE_3,
        names=NAMES,
        calibration=calibration_error(contents.reliability),
        table_2_notes=table_2_notes(contents.table_2) if contents.table_2 else [],
        validity_notes=notes(contents.validity) if contents.validity else [],
        agreements=_agreements(contents.validity),
        verdicts=VERDICTS,
        plan_parts=contents.plans.parts() if contents.plans else {},
        plan_comparisons=_comparisons(contents.plans),
        wrong=contents.plans.wrong()[:WRONG_PLANS] if contents.plans else [],
        provenance=[(key.replace("_", " "), _said(v)) for key, v in contents.provenance.items()],
    )


def _charts(contents: Contents) -> dict[str, str]:
    found = {
        "table_1": intervals(_of_table_1(contents.table_1), "F-scores of Table 1 with intervals"),
        "reliability": reliability(contents.reliability, "Reliability of correspondences"),
        "curve": re.sub("<metadata>.*?</metadata>", "", contents.curve_svg, flags=re.DOTALL),
    }
    if contents.table_2:
        found["table_2"] = intervals(_of_table_2(contents.table_2), "Table 2 with intervals")
    if contents.plans:
        rows = contents.plans.part(WHOLE)
        found["table_3"] = intervals(_of_table_3(rows), "Table 3 with intervals")
        found["people"] = intervals(_of_table_3(contents.plans.people), "Table 3 by people")
        shown = {f"compared: {what}": c for what, c in _comparisons(contents.plans).items()}
        for name, compared in {**shown, "people_compared": contents.plans.people_compared}.items():
            found[name] = differences(_of_comparisons(compared), "Differences with intervals")
        found["plans"] = reliability(contents.plans.reliability, "Reliability of plans")
    return found


def _of_table_1(rows: Sequence[Row]) -> list[Bar]:
    return [
        Bar(row.type, row.f.value, row.f.low, row.f.high, PAPER_TABLE_1[row.type].f) for row in rows
    ]


def _of_table_2(results: Results) -> list[Bar]:
    return [
        Bar(f"{row.configuration} video{what}", *bounds, PAPER_TABLE_2[row.configuration])
        for row in results.rows
        for what, bounds in (("", row.share), (", other raters", row.two_way))
    ]


def _comparisons(plans: Plans | None) -> dict[str, list[Compared]]:
    """The judge's comparisons by what is compared."""
    found: dict[str, list[Compared]] = {}
    for c in plans.compared if plans else ():
        what = f"{HEADINGS.get(c.verdict, c.verdict)} compared on {TITLES.get(c.subset, c.subset)}"
        found.setdefault(what.capitalize(), []).append(c)
    return found


def _of_table_3(rows: Sequence[PlanRow]) -> list[Bar]:
    return [
        Bar(
            NAMES.get(row.configuration, row.configuration),
            math.nan if row.precision is None else row.precision,
            *_bounds(row),
            PAPER_TABLE_3.get(row.configuration),
        )
        for row in rows
    ]


def _of_comparisons(compared: Sequence[Compared]) -> list[Bar]:
    return [Bar(f"{c.one} − {c.other}", c.difference, *_bounds(c)) for c in compared]


def _bounds(found: PlanRow | Compared) -> tuple[float, float]:
    if found.low is None or found.high is None:
        return math.nan, math.nan
    return found.low, found.high


def _agreements(validity: Validity | None) -> list[tuple[str, str, Agreement]]:
    """The verdicts' agreement with people by verdict and pairs, near misses first."""
    if validity is None:
        return []
    near = [
        (VERDICTS[verdict], f"another video: {GROUPS[name]}", found)
        for verdict, groups in validity.near_misses.items()
        for name, found in groups.items()
    ]
    own = validity.own_videos.items()
    return [*near, *((VERDICTS[verdict], "its own video", found) for verdict, found in own)]


def _said(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _two(value: float | None) -> str:
    return "–" if value is None or math.isnan(value) else f"{value:.2f}"


def _count(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"


def _signed(value: float) -> str:
    return f"{value:+.2f}".replace("-", "−")


def _to(low: float | None, high: float | None, digits: int = 2) -> str:
    return interval(low, high, f"{{:.{digits}f}}–{{:.{digits}f}}")


def _signed_to(low: float | None, high: float | None) -> str:
    return "–" if low is None or high is None else f"{_signed(low)} to {_signed(high)}"


def _three(value: float | None) -> str:
    return "–" if value is None or math.isnan(value) else f"{value:.3f}"
