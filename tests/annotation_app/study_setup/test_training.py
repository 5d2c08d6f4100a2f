"""A dataset by LeRobot, corrected by five people, and a policy that LeRobot trains on the copy."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("av", reason="the extra `render` is not installed")

from corpus_tools.cli.console import run
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.language_rows import Language
from corpus_tools.lerobot.language_writing import EpisodeLanguage, write_language
from tests.annotation_app.browser import Browser, described
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.annotation_app.study_setup.test_robot_episodes import export
from tests.corpus_tools.lerobot.test_lerobot_itself import lerobot
from tests.corpus_tools.lerobot.test_lerobot_itself import pytestmark as needs_lerobot
from tests.lerobot_itself import FPS, LENGTHS, TASKS, write_dataset

PEOPLE = 5
MODEL = ((0.0, "reach"), (0.2, "take"), (0.4, "lift"))
"""A model's steps of each episode; people write another text for the second one."""
TRUE = ((0.0, "reach"), (0.2, "grasp"), (0.4, "lift"))
WRONG, RIGHT = 3, "Nudge."
"""An episode whose task four people correct, and what they write."""
pytestmark = needs_lerobot

_HAS_EXTRAS = """
from importlib.util import find_spec
print(all(map(find_spec, ("accelerate", "diffusers", "transformers"))))
"""

_TRAIN = """
import json, sys
from pathlib import Path
from tokenizers import Tokenizer, models, normalizers, pre_tokenizers
from transformers import CLIPConfig, CLIPModel, PreTrainedTokenizerFast
from lerobot.policies.multi_task_dit.modeling_multi_task_dit import MultiTaskDiTPolicy
from lerobot.processor.tokenizer_processor import TokenizerProcessorStep
from lerobot.scripts.lerobot_train import main

root, out, texts = sys.argv[1], Path(sys.argv[2]), json.loads(sys.argv[3])
clip = str(out / "clip")  # with random weights, and few words
split = pre_tokenizers.BertPreTokenizer()
words = {word for text in texts for word, _ in split.pre_tokenize_str(text.lower())}
vocabulary = {word: n for n, word in enumerate(["<pad>", "<unk>", "</s>", *sorted(words)])}
tokenizer = Tokenizer(models.WordLevel(vocabulary, unk_token="<unk>"))
tokenizer.normalizer, tokenizer.pre_tokenizer = normalizers.Lowercase(), split
PreTrainedTokenizerFast(
    tokenizer_object=tokenizer, pad_token="<pad>", unk_token="<unk>", eos_token="</s>"
).save_pretrained(clip)
size = {"hidden_size": 16, "intermediate_size": 16, "num_hidden_layers": 1,
        "num_attention_heads": 2, "projection_dim": 16}
CLIPModel(CLIPConfig(
    text_config={**size, "vocab_size": len(vocabulary), "pad_token_id": 0, "eos_token_id": 2},
    vision_config={**size, "image_size": 32, "patch_size": 16}, projection_dim=16,
)).save_pretrained(clip)

losses, tasks = [], set()
forward, get_task = MultiTaskDiTPolicy.forward, TokenizerProcessorStep.get_task

def kept_loss(self, batch):
    result = forward(self, batch)
    losses.append(float(result[0]))
    return result

def kept_task(self, transition):
    found = get_task(self, transition)
    tasks.update(found)
    return found

MultiTaskDiTPolicy.forward, TokenizerProcessorStep.get_task = kept_loss, kept_task
options = {
    "dataset.repo_id": "me/corrected", "dataset.root": root, "dataset.video_backend": "pyav",
    "policy.type": "multi_task_dit", "policy.push_to_hub": "false", "policy.device": "cpu",
    "policy.text_encoder_name": clip, "policy.vision_encoder_name": clip,
    "policy.image_crop_shape": "[32,32]", "policy.tokenizer_max_length": 16,
    "policy.horizon": 4, "policy.n_action_steps": 2, "policy.hidden_dim": 16,
    "policy.num_heads": 2, "policy.num_layers": 1,
    "batch_size": sys.argv[4], "num_workers": 0, "steps": 2, "output_dir": out / "trained",
}
sys.argv = ["lerobot-train", *(f"--{name}={value}" for name, value in options.items())]
main()
saved = [str(file.relative_to(out)) for file in out.glob("trained/**/model.safetensors")]
print(json.dumps({"losses": losses, "tasks": sorted(tasks), "saved": saved}))
"""


def answer_all(app: Any) -> None:
    """Five people do all tasks; the first one accepts everything as it is."""
    for number in range(PEOPLE):
        person = Browser(app, study="arm")
        tasks = ("describe", "subtasks", "correct", "mark")
        person.practise(*tasks)
        for task in tasks:
            while (taken := person.lease(task, "arm")).status_code == 200:
                page = taken.json
                frames = round(page["payload"]["duration_s"] * FPS)
                is_wrong = number > 0 and frames == LENGTHS[WRONG]
                steps = [{"start_s": s, "text": text} for s, text in (TRUE if number else MODEL)]
                body: dict[str, Any] = {
                    "describe": described(f"Work for {frames} frames."),
                    "subtasks": {"subtasks": steps, "played_to_end": True},
                    "correct": (
                        {"verdict": "wrong", "text": RIGHT} if is_wrong else {"verdict": "right"}
                    ),
                    "mark": {"success": "success", "quality": 4},
                }[task]
                answered = person.answer(page["item"], body | person.watched(page))
                assert answered.status_code == 200, answered.text


def test_a_policy_is_trained_on_what_five_people_corrected(tmp_path: Path) -> None:
    if lerobot(_HAS_EXTRAS).strip() != "True":
        pytest.skip("that Python has no `lerobot[training,multi-task-dit]`")
    made = open_dataset(write_dataset(tmp_path / "made", "videos"))
    steps = EpisodeLanguage(tuple(Language("subtask", start_s, text) for start_s, text in MODEL))
    said = dict.fromkeys(range(len(LENGTHS)), steps)
    assert write_language(made, tmp_path / "set", said, attachments={}) == []

    study = tmp_path / "arm.yaml"
    assert run(["annotate", "init", str(study), "--videos", str(tmp_path / "set")]) == 0
    study.write_text(study.read_text().replace("answers: 3", f"answers: {PEOPLE}"))
    with set_up(study) as app:
        answer_all(app)
    copy = export(tmp_path)
    instance = ("--instance", str(tmp_path / "instance"))
    table, figures = tmp_path / "steps.csv", tmp_path / "figures.json"
    assert run(["annotate", "export", str(table), "--format", "proposed-steps.csv", *instance]) == 0
    assert run(["eval", "subtasks", str(table), "--json", "--out", str(figures)]) == 0
    (model,) = json.loads(figures.read_text())["models"]
    value = {one["measure"]: one["value"] for one in model["measures"]}
    wrong_share = (1 - 1 / PEOPLE) / len(MODEL)
    assert model["answers"] == PEOPLE * len(LENGTHS)
    assert value["text changed"] == pytest.approx(wrong_share)
    assert value["accepted"] == pytest.approx(1 - wrong_share)

    corrected = [task or f"Work for {n} frames." for task, n in zip(TASKS, LENGTHS, strict=True)]
    corrected[WRONG] = RIGHT
    frames = sum(LENGTHS) - len(LENGTHS)  # the policy leaves out the last frame of each
    trained = json.loads(
        lerobot(_TRAIN, copy, tmp_path, json.dumps(corrected), frames).splitlines()[-1]
    )
    assert trained["tasks"] == sorted(set(corrected))
    assert len(trained["losses"]) == 2
    assert all(map(math.isfinite, trained["losses"]))
    assert trained["saved"]
