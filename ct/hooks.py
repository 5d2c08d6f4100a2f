"""All hooks: what another distribution can add, and in which group of entry points.

Name a module in a group of ``pyproject.toml``; it is imported where its members are first needed
and calls the hook::

    [project.entry-points."g3.features"]
    my-features = "my_package.features"

    from ct.hooks import feature_set

    @feature_set("past", types=["PATH"], ...)
    def past(batch): ...

Three groups name the objects themselves: ``ct.commands`` click commands, ``ct.checks`` functions of
``ct doctor`` (:mod:`corpus_tools.doctor.diagnosis`), and ``g3.models`` functions that return a
model (:func:`g3.inference.grounder.open_model`).
"""

from __future__ import annotations

from pkgutil import resolve_name
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from annotation_app.crowds.crowd_registry import register as register_crowd
    from annotation_app.tasks.task_registry import register as register_task
    from corpus_tools.exporters.export_registry import register as register_exporter
    from corpus_tools.importers.importer_registry import register as register_importer
    from corpus_tools.world.looks.look_registry import drawn, look
    from corpus_tools.world.physics.behaviours import behaviour
    from corpus_tools.world.state.robot_script import register_action
    from corpus_tools.world.state.thing_kinds import register_kind
    from eval.judging.judge_registry import plan_judge
    from eval.parsing.parser_registry import parser
    from eval.table_3.grounder_registry import grounder
    from g3.actions.action_kinds import action_kind
    from g3.features.feature_registry import feature_set
    from g3.inference.potentials.potential_registry import potential

__all__ = [
    "action_kind",
    "behaviour",
    "drawn",
    "feature_set",
    "grounder",
    "look",
    "parser",
    "plan_judge",
    "potential",
    "register_action",
    "register_crowd",
    "register_exporter",
    "register_importer",
    "register_kind",
    "register_task",
]

HOOKS = MappingProxyType(
    {
        # From a batch of factors to an array of features.
        "feature_set": ("g3.features", "g3.features.feature_registry:feature_set"),
        # From a case to how far each candidate is from the words.
        "potential": ("g3.potentials", "g3.inference.potentials.potential_registry:potential"),
        # From a state to the possible actions; its step in scripts, and what that does in physics.
        "action_kind": ("g3.actions", "g3.actions.action_kinds:action_kind"),
        "register_action": ("g3.actions", "corpus_tools.world.state.robot_script:register_action"),
        "behaviour": ("g3.actions", "corpus_tools.world.physics.behaviours:behaviour"),
        # A kind of thing; how it is modelled in MuJoCo, as a function or as parts.
        "register_kind": ("ct.kinds", "corpus_tools.world.state.thing_kinds:register_kind"),
        "look": ("ct.looks", "corpus_tools.world.looks.look_registry:look"),
        "drawn": ("ct.looks", "corpus_tools.world.looks.look_registry:drawn"),
        # From a path to a corpus, and from a corpus to names and contents of files.
        "register_importer": ("ct.importers", "corpus_tools.importers.importer_registry:register"),
        "register_exporter": ("ct.exporters", "corpus_tools.exporters.export_registry:register"),
        # From a command to a plan, from a text to clauses, from a plan to a verdict.
        "grounder": ("ct.grounders", "eval.table_3.grounder_registry:grounder"),
        "parser": ("ct.parsers", "eval.parsing.parser_registry:parser"),
        "plan_judge": ("ct.judges", "eval.judging.judge_registry:plan_judge"),
        # A task of the annotation app, and a platform of workers.
        "register_task": ("ct.tasks", "annotation_app.tasks.task_registry:register"),
        "register_crowd": ("ct.crowds", "annotation_app.crowds.crowd_registry:register"),
    }
)
"""Hooks by name: the group of entry points, and the function as ``module:name``."""

if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        """Import a hook when it is first used: no extra is needed for the others."""
        if name not in HOOKS:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return resolve_name(HOOKS[name][1])
