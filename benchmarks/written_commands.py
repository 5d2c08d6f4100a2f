"""Commands that imitate people: ``python -m benchmarks.written_commands``.

Each line of ``benchmarks/written/*.jsonl`` has a yard, a command and the ends that are right. A
language model wrote them for this project, which had seen neither code nor rules: each set by
another writer, with a brief of its own. The robot stands at the origin and looks along x; positions
are in metres, headings in degrees. Some sets have trees, too, which that model made by hand.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from shapely.geometry import Point, Polygon

from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.importers.treebank import trees_of
from corpus_tools.world.scenarios.contexts import scenario_context
from corpus_tools.world.scenarios.scenario import Bounds, Layout, Robot, Scenario, Thing
from eval.statistics.intervals import bootstrap
from eval.table_3.baselines import BASELINES, missing
from eval.table_3.following import FollowedPlan, papers_own, plan_by_grounder, plan_of
from eval.table_3.grounder_registry import PlanTask, grounder_named
from eval.table_3.held_out import costs_without, data_of
from eval.table_3.outcomes import Outcome, reliability
from g3.actions.action_kinds import Action
from g3.actions.grounding_candidates import carrier
from g3.actions.robot_state import State, start_state
from g3.geometry.footprints import centre
from g3.geometry.plane import wrap
from g3.groundings import FloatArray
from g3.inference.grounder import Grounder
from g3.inference.potentials.potential_registry import potentials
from g3.inference.problem.costs import RandomCost, Scorer
from g3.inference.problem.loads_of_state import loads_of
from g3.inference.tree_choice import PARSES
from g3.language.parsing.trees import Parse, Tree
from g3.language.parsing.words import cut
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import IMPLICIT_FIGURE

FOLDER = Path(__file__).parent / "written"
NEAR_M, BESIDE_M, BETWEEN_M, SIDE_M = 6.5, 7.0, 2.6, 8.0
"""From the edge of a thing that is come to; between middles; from the middle between two; between
middles on a side."""
AT_M, HEADING_DEG = 1.5, 20.0
"""Largest errors of a robot's distance, in metres, and turn that a command specifies."""
SETS = tuple(sorted((path.stem for path in FOLDER.glob("*.jsonl")), key=int))
HELD_OUT = (
    *("19", "21", "25", "28", "32", "33", "36", "40", "44", "49", "73", "97"),
    *("111", "119", "123", "131", "135", "143", "151", "177", "178", "179"),
)
"""Sets that nobody has read, and that nothing is learned from."""
CHOICE = (*("102", "103", "104", "105", "106", "107", "171", "172", "173", "183", "185", "187"),)
"""Sets that the choice among plans is fitted to, and that the model of ends doesn't learn from."""
YARD = Layout("yard", "A yard.", (0, 0), 0, Bounds((-40, 40), (-40, 40)), {}, {})
Plan = Callable[[str, State], FollowedPlan]
"""Function from a command and a state to a plan."""


@dataclass(frozen=True, slots=True)
class Done:
    """Outcome of a command: its actions, and the state after them."""

    actions: Sequence[Action]
    after: State

    @property
    def handled(self) -> set[str]:
        """Ids of the loads that were picked up or put down."""
        return {a.object_id for a in self.actions} - {""}

    def middle(self, name: str) -> FloatArray:
        """Return the final middle of a thing, shape (2,)."""
        return centre(self.after.thing(name).prism)

    def under(self, name: str) -> str | None:
        """Return the id of what a load is on; None if it is held, or stays on the ground."""
        if self.after.held == name:
            return None
        below = carrier(self.after, name)
        ground = "ground" if name in self.handled else None
        return below.id if below else ground


def _on_side(done: Done, load: str, thing: str) -> FloatArray:
    """Return a load's offset from a thing, behind and to the left of it, on the ground; shape (2,).

    NaN where it isn't on the ground near it. Seen from the start, or along the robot's axis.
    """
    away = done.middle(load) - done.middle(thing)
    if done.under(load) != "ground" or np.linalg.norm(away) > SIDE_M:
        return np.full(2, np.nan)
    ahead = done.middle(thing) / np.linalg.norm(done.middle(thing))
    return np.array([away @ ahead, away @ (-ahead[1], ahead[0])])


def _is_near(done: Done, thing: str) -> bool:
    outline = Polygon(done.after.thing(thing).prism.xy)
    return bool(outline.distance(Point(done.after.pose[:2])) < NEAR_M)


def _is_beside(done: Done, load: str, thing: str) -> bool:
    away = np.linalg.norm(done.middle(load) - done.middle(thing))
    return done.under(load) == "ground" and bool(away < BESIDE_M)


def _is_between(done: Done, load: str, one: str, other: str) -> bool:
    middle = (done.middle(one) + done.middle(other)) / 2
    away = np.linalg.norm(done.middle(load) - middle)
    return done.under(load) == "ground" and bool(away < BETWEEN_M)


def _looks(done: Done, degrees: str) -> bool:
    off = wrap(done.after.pose[2] - np.deg2rad(float(degrees)))
    return bool(abs(off) < np.deg2rad(HEADING_DEG))


ENDS: dict[str, Callable[..., bool]] = {
    "pick": lambda done, load: done.after.held == load,
    "on": lambda done, load, deck: done.under(load) == deck,
    "ground": lambda done, load: done.under(load) == "ground",
    "by": _is_beside,
    "left-of": lambda done, *named: bool(_on_side(done, *named)[1] > 0.3),
    "right-of": lambda done, *named: bool(_on_side(done, *named)[1] < -0.3),
    "front-of": lambda done, *named: bool(_on_side(done, *named)[0] < -0.2),
    "behind": lambda done, *named: bool(_on_side(done, *named)[0] > 0.2),
    "between": _is_between,
    "near": _is_near,
    "moved": lambda done, load: done.handled == {load},
    "still": lambda done, load: done.after.held == load and not done.handled - {load},
    "at": lambda done, x, y: bool(np.hypot(*(done.after.pose[:2] - (float(x), float(y)))) < AT_M),
    "heading": _looks,
    "gone": lambda done: bool(done.actions) and not done.handled,
}
"""Checks of an outcome, by the name of the end. Several ends are joined by "&"."""


def is_right(wanted: Sequence[str], done: Done) -> bool:
    """Check that an outcome satisfies one of the right ends."""
    return any(_ends_so(end, done) for end in wanted)


def _ends_so(end: str, done: Done) -> bool:
    parts = [part.split() for part in end.split("&")]
    if [part[0] for part in parts] == ["near"] and done.handled:
        return False  # who is only to go somewhere leaves loads alone
    return all(ENDS[name](done, *named) for name, *named in parts)


def state_of(record: dict[str, Any]) -> State:
    """Return the state of a line's yard before the command."""
    things = {}
    for name, (kind, *where) in record["things"].items():
        at, heading, deck = [*where, None, None, None][:3]
        spot = tuple(at) if at else None
        lifted = True if kind == "barrel" else None  # as the writers were told
        thing = Thing(kind, spot, float(heading or 0), deck or None, lifted)
        things[name.replace("_", "-")] = thing
    robot = Robot((0, 0), 0, record["held"])
    return start_state(scenario_context(Scenario("yard", "", YARD, things, {}, robot, ())))


def records_of(name: str) -> list[dict[str, Any]]:
    """Return the commands of a set with their yards and ends."""
    lines = (FOLDER / f"{name}.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines]


def learned_cost(corpora: Sequence[str]) -> Scorer:
    """Return the cost that a model has learned from corpora."""
    known = [open_corpus(name) for name in corpora]
    return costs_without(data_of(known), load_choices_of(known))("")


def by_model(grounder: Grounder, parse: Parse | None = None, *, parses: int = PARSES) -> Plan:
    """Return a function that follows commands with a model; with given trees, only one command."""

    def plan(text: str, start: State) -> FollowedPlan:
        command = text if parse is None else parse
        return plan_of(grounder.follow(command, start, least=0.0, parses=parses, insist=True))

    return plan


def by_trees(grounder: Grounder, records: Sequence[dict[str, Any]]) -> Plan:
    """Return a function that follows commands with a model by their annotated trees."""
    trees = {
        r["text"]: trees_of(r["trees"], r.get("taken_back", ""), r["text"])[0] for r in records
    }

    def plan(text: str, start: State) -> FollowedPlan:
        return by_model(grounder, Parse(text, (Tree(trees[text], 1.0),)))(text, start)

    return plan


def ablated(cost: Scorer) -> dict[str, Plan]:
    """Return the model with each of its parts off alone, and with all of them off."""
    rules = {
        "soft potentials": [p.name for p in potentials() if not p.is_hard],
        "hard constraints": [p.name for p in potentials() if p.is_hard],
    }
    return {
        "the model": by_model(Grounder(cost)),
        "a verb and a thing for trees": _by_verb_and_thing(Grounder(cost)),
        "the best tree alone": by_model(Grounder(cost), parses=1),
        "random costs": by_model(Grounder(RandomCost())),
        **{f"no {name}": by_model(Grounder(cost, without=off)) for name, off in rules.items()},
        "no rewriting": by_model(Grounder(cost, rewriting=False)),
        "the paper's own": by_model(papers_own(cost), parses=1),
        "all off": _by_verb_and_thing(papers_own(RandomCost())),
    }


def _by_verb_and_thing(grounder: Grounder) -> Plan:
    """Follow commands as if the first word were what is done, and all others one thing."""

    def plan(text: str, start: State) -> FollowedPlan:
        verb, *thing = cut(text).spans
        landmark = (SDC("OBJECT", words=tuple(thing)),) if thing else ()
        sdc = SDC("EVENT", figure=IMPLICIT_FIGURE, relation=(verb,), landmark1=landmark)
        return by_model(grounder, Parse(text, (Tree((sdc,), 1.0),)))(text, start)

    return plan


def _by_baseline(name: str) -> Plan:
    def plan(text: str, start: State) -> FollowedPlan:
        task = PlanTask(text, start, tuple(start.thing(n) for n in loads_of(start)))
        return plan_by_grounder(grounder_named(name), task)

    return plan


def parser_of(
    module: str, description: str | None, train: str = "aaai11,warehouse,automatic"
) -> argparse.ArgumentParser:
    """Return a parser of the corpora that are learned from."""
    parser = argparse.ArgumentParser(prog=f"python -m benchmarks.{module}", description=description)
    parser.add_argument("--train", default=train, help="corpora, with commas between")
    return parser


def main() -> None:
    parser = parser_of("written_commands", __doc__)
    parser.add_argument("--set", action="append", choices=SETS, dest="sets")
    parser.add_argument("--ablate", action="append", default=[], help="a potential to leave out")
    parser.add_argument("--ablations", action="store_true", help="turn off each part of the model")
    parser.add_argument("--every", type=int, default=1, help="follow every Nth command only")
    parser.add_argument("--wrong", action="store_true", help="show which commands go wrong")
    options = parser.parse_args()
    cost = learned_cost(options.train.split(","))
    ways = {
        **{name: _by_baseline(name) for name in BASELINES if name not in missing()},
        "random costs": by_model(Grounder(RandomCost())),
        "the model": by_model(Grounder(cost, without=options.ablate)),
    }
    if options.ablations:
        ways = ablated(cost)
    for name in options.sets or SETS:
        records = records_of(name)[:: options.every]
        yards = np.array([record["world"] for record in records])
        by_hand = {}
        if all("trees" in record for record in records):
            by_hand["the model, annotated trees"] = by_trees(Grounder(cost), records)
        for how, plan in (ways | by_hand).items():
            done = [followed(record, plan) for record in records]
            right = np.array([outcome.correct for outcome in done])
            if options.wrong and how == "the model":
                wrong = (o for o in done if not o.correct)
                print(*(f"  {o.scenario} {o.text!r}" for o in wrong), sep="\n")
            found = bootstrap(right, yards, rng=np.random.default_rng(0))
            stated = float(np.mean([outcome.probability for outcome in done]))
            curve = (
                f"  stated {stated:.2f}, error {reliability(done)[0].value:.2f}" if stated else ""
            )
            print(
                f"{name:7} {how:28} {right.sum():4} of {len(right)}  "
                f"{found.value:.2f} ({found.low:.2f} to {found.high:.2f}){curve}",
                flush=True,
            )
            kinds = np.array([record.get("kind", "") for record in records])
            for kind in sorted({*kinds} - {""}):
                own = right[kinds == kind]
                print(f"        {kind:20} {own.sum():3} of {len(own)}  {own.mean():.2f}")


def followed(record: dict[str, Any], follow: Plan, name: str = "") -> Outcome:
    """Follow a command and return its outcome."""
    plan = follow(record["text"], state_of(record))
    own = plan.proposal
    done = Done(own.actions, plan.final) if own.actions and plan.final else None
    right = done is not None and is_right(record["want"], done)
    return Outcome(
        name, record["world"], record["text"], own.probability, right, "", evidence=plan.evidence
    )


if __name__ == "__main__":
    main()
