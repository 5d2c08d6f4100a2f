import os
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from g3.errors import CorpusError, nearest
from g3.registry import Registry


def test_a_broken_extension_is_told_and_stops_nothing(tmp_path):
    info = tmp_path / "broken-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[ct.kinds]\ngone = there.is.no.such.module\n")
    code = "from corpus_tools.world.state.thing_kinds import KINDS; print('truck' in KINDS)"
    done = subprocess.run(
        [sys.executable, "-c", code],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )
    assert done.stdout == "True\n"
    assert "ct.kinds: the extension gone can't be loaded: ModuleNotFoundError" in done.stderr


def test_a_function_is_registered_once_with_the_first_line_of_its_docs():
    known: Registry[tuple[str, object]] = Registry("greeting")

    def wave() -> None:
        """Wave.

        With both hands.
        """

    decorate = known.adding("wave", lambda about, function: (about, function))
    assert decorate(wave) is wave
    assert dict(known) == {"wave": ("Wave.", wave)}
    with pytest.raises(ValueError, match="the greeting 'wave' is registered already"):
        decorate(lambda: None)
    assert dict(known) == {"wave": ("Wave.", wave)}


def test_unknown_names_are_answered_with_the_nearest():
    known: Registry[str] = Registry("greeting", "my.greetings")
    for name in ("wave", "nod", "bow"):
        known.add(name.upper(), name)
    assert (list(known), known.by_name()) == (["wave", "nod", "bow"], ("BOW", "NOD", "WAVE"))
    known.check(("bow", "wave"))
    assert known.known("nod") == "NOD"
    with pytest.raises(CorpusError) as error:
        known.known("wafe", "--with")
    assert str(error.value) == (
        "--with: there is no greeting 'wafe' (did you mean 'wave'? give one of bow, nod, wave; "
        "or install a package that adds it by the entry point group my.greetings)"
    )


def test_an_error_lists_no_thousand_names():
    numbers = [f"n{i}" for i in range(1000)]
    error = CorpusError.unknown("thing", "box", numbers)
    assert error.fix.endswith("n10, n11 and 988 more")
    assert CorpusError.unknown("thing", "box", ()).fix == "there are none"
    assert CorpusError.unknown("thing", "box", numbers, more="run list").fix == "run list"


def test_of_many_names_the_few_nearest_are_suggested_and_how_all_are_listed():
    names = [f"{layout}_pick_up_{load}" for layout in "abcdefgh" for load in ("tires", "boxes")]
    near = CorpusError.unknown("scenario", "c_pick_up_tyres", names, more="run list").fix
    assert near.startswith("did you mean 'c_pick_up_tires'")
    assert near.endswith("? run list")
    assert sum(name in near for name in names) <= 3
    part = CorpusError.unknown("scenario", "D_PICK", names).fix
    assert part.startswith("did you mean 'd_pick_up_")
    assert "'d_pick_up_tires'" in part
    assert "'d_pick_up_boxes'" in part


@given(st.text(max_size=20), st.lists(st.text(max_size=20), max_size=30, unique=True))
def test_any_name_is_answered_briefly_and_a_known_one_with_itself(name, known):
    near = nearest(name, known)
    assert len(near) <= 3
    assert set(near) <= set(known)
    assert name not in known or name.lower() == near[0].lower()
    assert f"there is no thing {name!r}" in str(CorpusError.unknown("thing", name, known))
