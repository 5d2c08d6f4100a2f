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
    options={"table1": "--table 1", "table2": "--table 2", "table3": "--table 3"},
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

    Each command has options of its own: see `ct eval table1 --help`. A command may be written as an
    option too, such as `ct eval table1` or `ct eval report FOLDER`.
    """,
    options_metavar="",
    epilog="\b\nExamples:\n"
    "  ct eval table1 --corpus aaai11 --cv scenario\n"
    "  ct eval table2\n"
    "  ct eval table3 --test aaai11\n"
    "  ct eval table3 --help",
)
