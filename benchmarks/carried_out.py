"""Plans of several loads in physics: ``python -m benchmarks.carried_out``.

In each bundled scenario and in generated ones a command asks for several loads to be moved. Its
plan is carried out to its end. Counts the plans that the rehearsal allows, those without a failure,
and those of them that end as planned.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator

import numpy as np

from benchmarks.written_commands import learned_cost, parser_of
from corpus_tools.following.plan_execution import Episode, run_plan, why_not
from corpus_tools.following.start_states import scenario_start
from corpus_tools.runtime.shipped import bundled
from corpus_tools.world.scenarios.contexts import scenario_context
from corpus_tools.world.scenarios.random_scenarios import generate
from corpus_tools.world.scenarios.scenario_reading import read_layouts, scenario_files
from g3.actions.grounding_candidates import carrier, is_surface
from g3.actions.robot_state import State, is_load, start_state
from g3.geometry.footprints import centre
from g3.inference.grounder import Grounder, Plan

NEAR_M = 2.5
"""Largest distance of a load on the ground from where the plan has it."""
ONTO = ("Put all the {loads} on the {deck}.", "Load every {load} onto the {deck}.")
BESIDE = ("Move both {loads} next to the {mark}.", "Bring all the {loads} to the {mark}.")
PLURALS = {"box": "boxes"}


def main() -> None:
    parser = parser_of("carried_out", __doc__, "warehouse")
    parser.add_argument("--worlds", type=int, default=200, help="so many generated worlds")
    parser.add_argument("--seed", type=int, default=0, help="of the generated worlds")
    options = parser.parse_args()
    grounder = Grounder(learned_cost(options.train.split(",")))
    generated = _generated(options.seed, options.worlds)
    for name, worlds in (("bundled", _bundled()), ("generated", generated)):
        counts: Counter[str] = Counter()
        for where, start in worlds:
            for text in commands(start):
                counts[_tried(grounder, where, text, start)] += 1
        allowed = sum(n for how, n in counts.items() if how not in ("one load", "not allowed"))
        share = counts["as planned"] / max(allowed, 1)
        print(f"{name}: {dict(counts)}; as planned {share:.3f} of {allowed}", flush=True)


def _bundled() -> Iterator[tuple[str, State]]:
    return ((name, scenario_start(name)) for name in sorted(scenario_files(bundled()["warehouse"])))


def _generated(seed: int, count: int) -> Iterator[tuple[str, State]]:
    layouts = read_layouts(bundled()["warehouse"])
    for number in range(count):
        world = scenario_context(generate(seed, number, layouts))
        yield f"generated {number}", start_state(world)


def commands(start: State) -> list[str]:
    """Return a command about several loads of the kind that there is most of, if there is one."""
    kinds: dict[str, list[str]] = defaultdict(list)
    for thing in start.context.objects:
        if is_load(start, thing.id) and thing.id != start.held:
            kinds[thing.labels[0]].append(thing.id)
    load = max(kinds, key=lambda kind: len(kinds[kind]), default="")
    others = [o for o in start.context.objects if not is_load(start, o.id)]
    others = [o for o in others if o.id != start.context.agent_id]
    if start.held is not None or len(kinds.get(load, ())) < 2 or not others:
        return []
    number = len(kinds[load]) + len(others)
    mark = others[number % len(others)]
    words = {"load": load, "loads": PLURALS.get(load, f"{load}s")}
    if is_surface(mark):
        return [ONTO[number % 2].format(**words, deck=mark.labels[-1])]
    return [BESIDE[number % 2].format(**words, mark=mark.labels[-1])]


def _tried(grounder: Grounder, where: str, text: str, start: State) -> str:
    plan = grounder.follow(text, start, least=0.0, insist=True).plan
    if plan is None or len({a.object_id for a in plan.actions} - {""}) < 2:
        return "one load"
    problem = why_not(start, plan.actions)
    if problem:
        print(f"  {where}: {text!r} not allowed: {problem}", flush=True)
        return "not allowed"
    done = run_plan(start, plan.actions, rate_hz=5.0)
    if done.failure is not None:
        print(f"  {where}: {text!r} failed: {done.failure}", flush=True)
        return "failed"
    apart = _apart(plan, done)
    if apart:
        print(f"  {where}: {text!r} ends otherwise: {apart}", flush=True)
        return "ends otherwise"
    return "as planned"


def _apart(plan: Plan, done: Episode) -> str:
    """Return how the end of an episode differs from the plan's; empty if it doesn't."""
    if done.held != plan.state.held:
        return f"{done.held} on the forks, not {plan.state.held}"
    for load in {a.object_id for a in plan.actions if a.kind.leaves}:
        on, planned = carrier(done.end, load), carrier(plan.state, load)
        if (on and on.id) != (planned and planned.id):
            return f"{load} on {on and on.id}, not {planned and planned.id}"
        away = centre(done.end.thing(load).prism) - centre(plan.state.thing(load).prism)
        if on is None and np.linalg.norm(away) > NEAR_M:
            return f"{load} {np.linalg.norm(away):.1f} m away"
    return ""


if __name__ == "__main__":
    main()
