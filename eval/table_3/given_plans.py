"""Plans by other programs, read from a file: a row of Table 3 without a line of code."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import msgspec

from corpus_tools.corpus.answer_records import PlanLine, write_lines
from corpus_tools.following.plan_steps import read_steps, scene_shown
from corpus_tools.runtime.progress import OnProgress
from corpus_tools.runtime.terminal import note
from corpus_tools.tables.json_text import json_lines
from corpus_tools.tables.table_reading import lines_named
from eval.table_3.grounder_registry import PlanGrounder, PlanTask, Proposal
from g3.errors import FormatError

FIX = "`ct eval table3 --write-tasks FILE` writes the form to fill in"


@dataclass(frozen=True)
class GivenPlans(PlanGrounder):
    """A file of plans, with the numbers of their lines, as a grounder with the file's name."""

    path: str
    lines: tuple[tuple[int, PlanLine], ...]

    @property
    def name(self) -> str:
        """Name of its row: the file's name without its suffix."""
        return Path(self.path).stem

    @property
    def about(self) -> Mapping[str, object]:
        """Name of the file, and a digest of its plans."""
        content = msgspec.json.encode([line for _, line in self.lines])
        digest = hashlib.sha256(content).hexdigest()
        return {"file": Path(self.path).name, "plans": len(self.lines), "sha256": digest}

    @cached_property
    def _by_task(self) -> Mapping[tuple[str, str], tuple[int, PlanLine]]:
        return {(line.command, line.heading): (n, line) for n, line in self.lines}

    def prepare(self, tasks: Sequence[PlanTask], on_progress: OnProgress) -> None:
        """Check that the file has a readable plan for each task."""
        gone = [t for t in tasks if (t.command, t.heading) not in self._by_task]
        if gone:
            heading = f" with the heading {gone[0].heading}" if gone[0].heading else ""
            raise FormatError(
                f"{len(gone)} of {len(tasks)} commands have no plan, such as "
                f"{gone[0].command!r}{heading}",
                where=self.path,
                fix=f"give a plan for each, [] where you refuse it; {FIX}",
            )
        asked = {(task.command, task.heading) for task in tasks}
        unused = [number for key, (number, _) in self._by_task.items() if key not in asked]
        if unused:
            count = f"{len(unused)} of {len(self.lines)} plans"
            note(
                f"note: {self.path}: {count} are of no command that is followed, and aren't used: "
                f"{lines_named(unused)}"
            )
        for task in tasks:
            self.propose(task)

    def propose(self, task: PlanTask, learned: object = None) -> Proposal:
        """Return the plan of the file; errors about unknown names also name the line."""
        number, line = self._by_task[task.command, task.heading]
        try:
            plan = read_steps(line.actions or (), task.start)
        except FormatError as error:
            where = f"{self.path}:{number}, command {line.command}, {error.where}"
            raise FormatError(error.what, where=where, fix=error.fix) from error
        if plan.why_not:
            return Proposal(note=plan.why_not)
        return Proposal(plan.actions, line.probability, line.note)


def read_plans(path: Path) -> GivenPlans:
    """Read a file of plans; each line is filled in, and no line is there twice."""
    lines = list(json_lines(path, PlanLine, fix=FIX))
    seen: dict[tuple[str, str], int] = {}
    for number, line in lines:
        where, first = f"{path}:{number}", seen.setdefault((line.command, line.heading), number)
        if first != number:
            raise FormatError(
                f"command {line.command!r} has a plan in line {first} already",
                where=where,
                fix="give one plan a command",
            )
        if line.actions is None:
            raise FormatError(
                f"the plan of command {line.command!r} isn't filled in",
                where=where,
                fix="give its actions, [] where you refuse the command",
            )
    bare = [(n, msgspec.structs.replace(line, text="", scene=None)) for n, line in lines]
    return GivenPlans(str(path), tuple(bare))


def write_tasks(path: Path, tasks: Iterable[PlanTask]) -> int:
    """Write the form to fill in, a line for each command with its world; return how many."""
    lines = (
        PlanLine(command=t.command, heading=t.heading, text=t.text, scene=scene_shown(t.start))
        for t in tasks
    )
    return write_lines(path, lines)
