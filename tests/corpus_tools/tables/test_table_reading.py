"""Tables as other programs save them: encodings, blank rows, columns, numbers."""

from __future__ import annotations

import codecs
import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from corpus_tools.tables.table_reading import Row, read_table
from g3.errors import FormatError


def rows_of(folder: Path, content: str | bytes, suffix: str = ".csv") -> list[Row]:
    file = folder / f"t{suffix}"
    file.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_table(file, ("video",))


@pytest.mark.parametrize(
    "content",
    [
        codecs.BOM_UTF8 + b"video,id\na.mp4,7\n",
        b"video,id\r\na.mp4,7\r\n",
        b"video,id\ra.mp4,7\r",
        b"\n\nvideo,id\n\na.mp4,7\n,\n , \n",
        b"video,id,,\na.mp4,7,,\n,,,\n",
        b"video , id\na.mp4,7,,,\n",
        b'"video","id"\n"a.mp4","7"',
    ],
)
def test_a_table_is_read_however_it_was_saved(tmp_path: Path, content: bytes) -> None:
    (row,) = rows_of(tmp_path, content)
    assert row.values == {"video": "a.mp4", "id": "7"}


@pytest.mark.parametrize(
    ("content", "where", "what"),
    [
        ("video,id\na.mp4,1\n".encode("utf-16"), "", "UTF-16"),
        ("video,id\na.mp4,1\n".encode("utf-16-le"), ":1:2", "UTF-16"),
        ("video,id\na.mp4,1\n".encode("utf-32"), "", "UTF-32"),
        (b"video,id\na.mp4,\xe9\n", ":2:7", "byte 16 is not UTF-8"),
        (b"\xef\xbb\xbfvideo\n\xe9\n", ":2:1", "byte 10 is not UTF-8"),
        (b"video,id\na.mp4,a\0\n", ":2:8", "NUL"),
        (b"video;id\na.mp4;1\n", ":1:6", "separated by semicolons"),
        (b"video\tid\na.mp4\t1\n", ":1:6", "separated by tabs"),
        (b'\n\r\n"video";"id"\n', ":3:8", "separated by semicolons"),
        (b"video,id,id\n", ":1:10", "two columns are called 'id'"),
        (b"a.mp4,1\n", ":1:1", "there is no column 'video' in the first row, which has a.mp4, 1"),
        (b"", ":1:1", "empty"),
        (b"\n,,\n", ":1:1", "empty"),
        (b"video,id\na.mp4\n", ":2:1", "fewer"),
        (b"video,id\na.mp4,1,2\n", ":2:9", "more"),
    ],
)
def test_what_is_wrong_is_named_with_line_and_column(
    tmp_path: Path, content: bytes, where: str, what: str
) -> None:
    with pytest.raises(FormatError) as caught:
        rows_of(tmp_path, content)
    assert caught.value.where == f"{tmp_path / 't.csv'}{where}"
    assert what in caught.value.what


def test_what_is_not_used_is_noted(tmp_path: Path) -> None:
    file = tmp_path / "t.csv"
    file.write_text(',video,command\n0,a.mp4,"Go.\nStop."\n1,b.mp4,Go.\n')
    notes: list[str] = []
    rows = read_table(file, on_note=notes.append)
    assert [row.line for row in rows] == [2, 4]
    assert rows[0].values == {"video": "a.mp4", "command": "Go.\nStop."}
    assert "column 1 has no name, and its cells aren't used: lines 2 and 4" in notes[0]
    assert "several lines from line 2" in notes[1]


def test_lines_of_json_end_at_line_feeds(tmp_path: Path) -> None:
    text = '{"video": "a.mp4", "note": "a\u2028b\x85c"}\r\n\n{"video": "b.mp4", "note": null}\n'
    first, second = rows_of(tmp_path, text, ".jsonl")
    assert first.values["note"] == "a\u2028b\x85c"
    assert (second.line, second.text("note")) == (3, "")


def test_numbers_keep_their_text(tmp_path: Path) -> None:
    text = '{"video": "a", "id": 1.10}\n{"video": "a", "id": "007"}\n{"video": "a", "id": 7e0}\n'
    rows = rows_of(tmp_path, f'{text}{{"video": "a", "id": 12345678901234567890123}}', ".jsonl")
    assert [row.text("id") for row in rows] == ["1.10", "007", "7e0", "12345678901234567890123"]
    assert rows[0].values["id"] == 1.1


@pytest.mark.parametrize(
    ("line", "place", "what"),
    [
        ('{"video": "b", "id": 1, "id": 2}', "2:25: id", "in the object already"),
        ('{"video": ["b"]}', "2:2: video", "no text and no number"),
        ('{"video": "b", "n": NaN}', "2:21", "malformed"),
        ('{"video": "b", "n": 1e999}', "2:16: n", "no text and no number"),
        ('["video"]', "2:1", "no object"),
        ('{"video": "b"', "2:14", "malformed"),
        ('{"video": "b"} {"video": "c"}', "2:16", "malformed"),
        ('{"video": "\\ud800"}', "2:12", "half of a character"),
    ],
)
def test_wrong_json_is_named_with_line_and_column(
    tmp_path: Path, line: str, place: str, what: str
) -> None:
    with pytest.raises(FormatError) as caught:
        rows_of(tmp_path, f'{{"video": "a"}}\n{line}\n', ".jsonl")
    assert caught.value.where == f"{tmp_path / 't.jsonl'}:{place}"
    assert what in caught.value.what


TEXTS = st.text(st.characters(exclude_categories=["Cs"]))
VALUES = TEXTS | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.booleans()


@settings(max_examples=50)
@given(st.lists(st.dictionaries(TEXTS, VALUES), max_size=5), st.booleans(), st.booleans())
def test_json_lines_are_read_as_they_were_written(
    tmp_path_factory: pytest.TempPathFactory,
    objects: list[dict[str, str | int | float | bool]],
    is_ascii: bool,
    is_windows: bool,
) -> None:
    file = tmp_path_factory.getbasetemp() / "t.jsonl"
    lines = [json.dumps({**one, "video": "v"}, ensure_ascii=is_ascii) for one in objects]
    file.write_bytes(
        "".join(f"{line}\r\n" if is_windows else f"{line}\n" for line in lines).encode()
    )
    rows = read_table(file, ("video",)) if objects else []
    assert [row.values for row in rows] == [{**one, "video": "v"} for one in objects]
    assert [row.line for row in rows] == list(range(1, len(objects) + 1))
