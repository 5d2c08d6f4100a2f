"""``ct eval``: the tables, the learning curve and the error lists of the paper's section 4."""

from __future__ import annotations

from eval.cli.extraction_commands import sdc
from eval.cli.modes import Modes
from eval.cli.plan_commands import end_to_end
from eval.cli.prediction_commands import errors, learning_curve, table_1
from eval.cli.rating_commands import judge_validity, power, table_2
from eval.cli.report_commands import report
from eval.cli.table_3_commands import table_3

evaluate = Modes(
    "eval",
    commands=[
        table_1,
        table_2,
        table_3,
        learning_curve,
        errors,
        sdc,
        end_to_end,
        judge_validity,
        report,
        power,
    ],
    help="""Measure models and plans: the paper's tables, and more.

    Choose one mode. Each has its own options: see `ct eval --table 1 --help`.
    """,
    options_metavar="",
    subcommand_metavar="MODE [OPTIONS]...",
    epilog="\b\nExamples:\n"
    "  ct eval --table 1 --corpus aaai11 --cv scenario\n"
    "  ct eval --table 2 --corpus aaai11\n"
    "  ct eval --table 3 --judge automatic --train aaai11 --test aaai11\n"
    "  ct eval --table 3 --help",
)
