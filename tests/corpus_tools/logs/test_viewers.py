"""What viewers find in a log: the published schemas, frames, entities and lines."""

from __future__ import annotations

import io
import typing
from dataclasses import replace
from pathlib import Path

import jsonschema
import msgspec
import pytest
from foxglove_schemas_protobuf import FrameTransforms_pb2, Log_pb2, SceneUpdate_pb2
from google.protobuf.descriptor import Descriptor, FieldDescriptor
from google.protobuf.json_format import ParseDict
from mcap.reader import make_reader

from corpus_tools.logs import foxglove
from corpus_tools.logs.channels import CHANNELS
from corpus_tools.logs.foxglove import Time
from corpus_tools.logs.log_writing import entities, to_bytes
from corpus_tools.world.state.thing_kinds import PAINTS
from tests.corpus_tools.video import recordings

DATASETS = Path(__file__).parents[3] / "datasets"
NUMBERS = {FieldDescriptor.TYPE_DOUBLE: "number", FieldDescriptor.TYPE_FLOAT: "number"}
OTHERS = {
    FieldDescriptor.TYPE_STRING: "string",
    FieldDescriptor.TYPE_BOOL: "boolean",
    FieldDescriptor.TYPE_ENUM: "integer",
    FieldDescriptor.TYPE_FIXED32: "integer",
    FieldDescriptor.TYPE_UINT32: "integer",
}
BASE64 = {FieldDescriptor.TYPE_BYTES: "string"}  # as JSON messages have them
OPTIONAL = {"message_id", "lineage"}  # in the published JSON schemas, too
TIMES = {"google.protobuf.Timestamp", "google.protobuf.Duration"}


def contents(recording):
    """Messages as (seconds, decoded JSON) by topic."""
    found = {}
    reader = make_reader(io.BytesIO(to_bytes(recording, name="", metadata={})))
    for schema, channel, message in reader.iter_messages():
        assert schema.encoding == "jsonschema"
        assert channel.message_encoding == "json"
        decoded = msgspec.json.decode(message.data)
        found.setdefault(channel.topic, []).append((message.log_time / 1e9, decoded))
    return found


def schemas(recording):
    summary = make_reader(io.BytesIO(to_bytes(recording, name="", metadata={}))).get_summary()
    return {schema.name: msgspec.json.decode(schema.data) for schema in summary.schemas.values()}


def agree(schema: dict, published: Descriptor) -> None:
    """Check that fields have the published names, kinds and nesting."""
    assert schema["type"] == "object"
    if published.full_name in TIMES:
        assert set(schema["properties"]) == {"sec", "nsec"}  # as JSON messages have them
        return
    fields = {field.name: field for field in published.fields}
    assert set(schema["properties"]) == set(fields) - OPTIONAL
    assert set(schema["required"]) == set(schema["properties"])
    for name, part in schema["properties"].items():
        field = fields[name]
        if field.is_repeated:
            assert part["type"] == "array"
        single = part["items"] if field.is_repeated else part
        if field.message_type:
            agree(single, field.message_type)
        else:
            assert single["type"] == (NUMBERS | OTHERS | BASE64)[field.type]


@pytest.mark.parametrize(
    "module", [FrameTransforms_pb2, SceneUpdate_pb2, Log_pb2], ids=lambda m: m.__name__
)
def test_schemas_agree_with_the_published_ones(driving, module):
    (published,) = module.DESCRIPTOR.message_types_by_name.values()
    agree(schemas(driving)[published.full_name], published)


def test_enumerations_agree_with_the_published_ones():
    level = Log_pb2.Log.DESCRIPTOR.fields_by_name["level"].enum_type
    assert level.values_by_name["INFO"].number == foxglove.INFO
    entity = SceneUpdate_pb2.SceneUpdate.DESCRIPTOR.fields_by_name["entities"].message_type
    line = entity.fields_by_name["lines"].message_type.fields_by_name["type"].enum_type
    assert line.values_by_name["LINE_LOOP"].number == foxglove.LINE_LOOP
    assert line.values_by_name["LINE_LIST"].number == foxglove.LINE_LIST


def simple(part: typing.Any) -> bool:
    """Whether viewers can read a field's schema."""
    if part["type"] == "object":
        return all(simple(field) for field in part["properties"].values())
    if part["type"] == "array":
        return part["items"]["type"] != "array" and simple(part["items"])
    return part["type"] in {"string", "number", "integer", "boolean"}


def test_viewers_can_read_every_schema(driving):
    found = schemas(driving)
    assert set(found) == {channel.schema for channel in CHANNELS.values()}
    for name, schema in found.items():
        assert schema["title"] == name
        assert schema["type"] == "object"
        assert simple(schema)


def test_what_moved_is_sent_and_all_of_it_each_second(driving):
    sent = {
        t: [frame["child_frame_id"] for frame in message["transforms"]]
        for t, message in contents(driving)["/tf"]
    }
    everything = ["robot", "tires", "robot/forks"]
    assert sent == {0.0: everything, 1.0: everything, 1.5: ["robot", "tires"], 2.0: everything}


def test_frames_are_in_the_site_and_the_forks_in_the_robot(driving):
    (_, message), *_ = contents(driving)["/tf"]
    parents = {f["child_frame_id"]: f["parent_frame_id"] for f in message["transforms"]}
    assert parents == {"robot": "world", "tires": "world", "robot/forks": "robot"}
    assert message["transforms"][1]["translation"] == {"x": 1.1, "y": 0.0, "z": 0.0}
    assert message["transforms"][1]["rotation"] == {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
    assert message["transforms"][2]["translation"]["z"] == 0.07


def test_the_scene_is_sent_whole_whenever_the_load_changes(driving):
    scenes = contents(driving)["/scene"]
    assert [t for t, _ in scenes] == [0.0, 1.0]
    for _, scene in scenes:
        entities = {entity["id"]: entity for entity in scene["entities"]}
        assert set(entities) == {"place 0", "robot", "tires", "robot/forks"}
        assert entities["tires"]["frame_id"] == "tires"
        assert entities["tires"]["texts"][0]["text"] == "tire pallet"
        assert entities["place 0"]["frame_id"] == "world"
        assert entities["place 0"]["texts"][0]["text"] == "receiving"
    box = scenes[0][1]["entities"][2]["cubes"][0]
    assert box["size"] == pytest.approx({"x": 1.0, "y": 1.2, "z": 0.7})
    assert box["pose"]["position"] == pytest.approx({"x": 0.0, "y": 0.0, "z": 0.35})
    before, after = (scene["entities"][2]["lines"][0]["color"] for _, scene in scenes)
    assert before != after


def test_things_are_drawn_in_their_colours():
    plain = recordings.scene()
    painted = [replace(o, colours=("red", "white")) for o in plain.objects]
    drawn = entities(replace(plain, objects=tuple(painted)), "", Time(0, 0))
    colours = [cube.color for entity in drawn if entity.texts for cube in entity.cubes]
    assert {(c.r, c.g, c.b) for c in colours} == {PAINTS["red"]}


def test_the_robot_is_sent_at_every_moment(driving):
    robot = contents(driving)["/robot"]
    assert [t for t, _ in robot] == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert [message["carries"] for _, message in robot] == ["", "", "tires", "tires", "tires"]
    assert [message["speed_m_s"] for _, message in robot] == [0.0, 0.0, -0.5, -1.0, -1.0]
    assert robot[3][1]["fork_height_m"] == 0.41
    assert robot[3][1]["pose"]["position"]["x"] == -0.5


def test_steps_are_told_to_people(driving):
    lines = [(t, message["message"]) for t, message in contents(driving)["/actions"]]
    assert lines == [
        (0.5, "pick_up object=tires: begins"),
        (2.0, "pick_up object=tires: is done"),
    ]
    ((_, steps),) = contents(driving)["/steps"]
    assert steps["steps"] == [
        {
            "action": "pick_up",
            "arguments": [{"name": "object", "value": "tires"}],
            "start_s": 0.5,
            "end_s": 2.0,
        }
    ]


def test_messages_are_in_the_order_of_their_times(driving):
    reader = make_reader(io.BytesIO(to_bytes(driving, name="", metadata={})))
    times = [message.log_time for _, _, message in reader.iter_messages(log_time_order=False)]
    assert times == sorted(times)


def test_every_message_fits_its_schema(driving):
    reader = make_reader(io.BytesIO(to_bytes(driving, name="", metadata={})))
    for schema, _, message in reader.iter_messages():
        jsonschema.validate(msgspec.json.decode(message.data), msgspec.json.decode(schema.data))


PUBLISHED = {
    "/tf": FrameTransforms_pb2.FrameTransforms,
    "/scene": SceneUpdate_pb2.SceneUpdate,
    "/actions": Log_pb2.Log,
}


def with_protobuf_times(message: typing.Any) -> typing.Any:
    """The message with times and durations as protobuf's own JSON writes them."""
    if isinstance(message, list):
        return [with_protobuf_times(part) for part in message]
    if not isinstance(message, dict):
        return message
    result = {name: with_protobuf_times(part) for name, part in message.items()}
    for name, part in message.items():
        if isinstance(part, dict) and set(part) == {"sec", "nsec"}:
            if name == "timestamp":
                result[name] = f"1970-01-01T00:00:{part['sec']:02}.{part['nsec']:09}Z"
            else:
                result[name] = f"{part['sec']}.{part['nsec']:09}s"
    return result


def json_schema(published: Descriptor) -> dict:
    """Foxglove's JSON Schema of a message, made as its own generator makes it.

    (``generateJsonSchema`` of @foxglove/schemas: all fields are required but the optional ones.)
    """
    if published.full_name in TIMES:
        lowest = {"minimum": 0} if published.name == "Timestamp" else {}
        nsec = {"type": "integer", "minimum": 0, "maximum": 999_999_999}
        return {
            "type": "object",
            "properties": {"sec": {"type": "integer", **lowest}, "nsec": nsec},
        }
    properties = {}
    for field in published.fields:
        if field.message_type:
            single = json_schema(field.message_type)
        elif field.enum_type:
            single = {"oneOf": [{"const": value.number} for value in field.enum_type.values]}
        else:
            single = {"type": (NUMBERS | OTHERS | BASE64)[field.type]}
            if single["type"] == "integer":
                single["minimum"] = 0  # all are unsigned
        properties[field.name] = {"type": "array", "items": single} if field.is_repeated else single
    required = [name for name in properties if name not in OPTIONAL]
    return {"type": "object", "properties": properties, "required": required}


@pytest.mark.parametrize("topic", PUBLISHED)
def test_every_message_passes_the_published_json_schema(driving, topic):
    validator = jsonschema.Draft202012Validator(json_schema(PUBLISHED[topic].DESCRIPTOR))
    messages = [message for _, message in contents(driving)[topic]]
    for message in messages:
        validator.validate(message)
    if topic == "/scene":  # as it refuses what is reduced
        del messages[0]["entities"][0]["arrows"]
        assert not validator.is_valid(messages[0])


def test_bundled_logs_pass_the_published_json_schemas():
    validators = {
        topic: jsonschema.Draft202012Validator(json_schema(module.DESCRIPTOR))
        for topic, module in PUBLISHED.items()
    }
    log = min(
        (DATASETS / "warehouse" / "logs").glob("*.mcap"), key=lambda file: file.stat().st_size
    )
    with log.open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages(topics=list(validators)):
            validators[channel.topic].validate(msgspec.json.decode(message.data))


@pytest.mark.parametrize("topic", PUBLISHED)
def test_every_message_is_one_of_the_published_schema(driving, topic):
    for t, message in contents(driving)[topic]:
        # Raises for a field that the schema has not, or of another type.
        published = ParseDict(with_protobuf_times(message), PUBLISHED[topic]())
        first = {"/tf": "transforms", "/scene": "entities"}.get(topic)
        stamped = getattr(published, first)[0] if first else published
        assert stamped.timestamp.ToNanoseconds() == t * 1e9


def test_published_messages_hold_the_poses(driving):
    (_, message), *_ = contents(driving)["/tf"]
    read = ParseDict(with_protobuf_times(message), FrameTransforms_pb2.FrameTransforms())
    robot, tires, forks = read.transforms
    assert (tires.parent_frame_id, tires.child_frame_id) == ("world", "tires")
    assert (tires.translation.x, tires.rotation.w) == (1.1, 1.0)
    assert forks.translation.z == 0.07
    assert robot.translation.x == 0.0
