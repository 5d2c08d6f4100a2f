from __future__ import annotations

import math
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from g3.errors import ModelError
from g3.language.similarity import resources
from g3.language.similarity.resources import wordnet, wordnet_identity
from g3.language.similarity.wordnet import WordNet, read_wordnet
from g3.language.similarity.wordnet_tables import wordnet_from_bytes, wordnet_to_bytes
from tests.g3.language.installed import needs_wordnet

#   1 thing ── 2 vehicle ── 3 truck, 4 cart       5 feeling (another root)
#          └── 6 box                        3 and 6 are also kinds of 7 container, a 1
DATA = b"""\
  1 the licence's lines begin with two blanks
00000001 03 n 01 thing 0 000 | what there is
00000002 03 n 01 vehicle 0 002 @ 00000001 n 0000 ~ 00000003 n 0000 | it carries
00000003 06 n 02 truck 0 lorry 0 002 @ 00000002 n 0000 @ 00000007 n 0000 | for @ 00000005 n 0000 x
00000004 06 n 01 cart 0 001 @ 00000002 n 0000 | a small one
00000005 12 n 01 feeling 0 000 | no thing
00000006 06 n 01 box 0 001 @i 00000007 n 0000 | it holds
00000007 06 n 01 container 0 001 @ 00000001 n 0000 | it contains
"""
INDEX = b"""\
  1 the licence's lines begin with two blanks
ax n 1 0 1 0 00000004
axis n 1 0 1 0 00000005
box n 2 1 @ 2 1 00000006 00000005
cart n 1 1 @ 1 1 00000004
container n 1 1 @ 1 1 00000007
feeling n 1 0 1 0 00000005
fire_truck n 1 1 @ 1 0 00000003
lorry n 1 1 @ 1 0 00000003
thing n 1 1 ~ 1 0 00000001
truck n 1 2 @ ~ 1 1 00000003
vehicle n 1 2 @ ~ 1 1 00000002
"""
EXCEPTIONS = b"axes ax axis\n"
COUNTS = b"""\
box%1:06:00:: 1 3
box%1:12:00:: 2 1
cart%1:06:00:: 1 5
run%2:38:00:: 1 106
unknown%1:06:00:: 1 9
"""
SMALL = read_wordnet(INDEX, DATA, EXCEPTIONS, COUNTS)
THING, VEHICLE, TRUCK, CART, FEELING, BOX, CONTAINER = range(1, 8)


def test_senses_are_in_their_order() -> None:
    assert SMALL.synsets("box") == (BOX, FEELING)
    assert SMALL.synsets("dog") == ()
    assert SMALL.synsets("fire trucks") == (TRUCK,)


@pytest.mark.parametrize(
    ("form", "lemmas"),
    [
        ("boxes", ("box",)),
        ("axes", ("ax", "axis")),
        ("Trucks", ("truck",)),
        ("vehicles", ("vehicle",)),
        ("lorries", ("lorry",)),
        ("feelings", ("feeling",)),
        ("zebra", ()),
        ("", ()),
    ],
)
def test_lemmas(form: str, lemmas: tuple[str, ...]) -> None:
    assert SMALL.lemmas(form) == lemmas


def test_ancestors_and_depth() -> None:
    assert SMALL.ancestors(TRUCK) == {TRUCK: 0, VEHICLE: 1, CONTAINER: 1, THING: 2}
    assert [SMALL.depth(s) for s in (THING, VEHICLE, TRUCK, BOX, FEELING)] == [1, 2, 3, 3, 1]


def test_path_and_wu_palmer_by_hand() -> None:
    assert SMALL.similarity("path", TRUCK, CART) == 1 / 3
    assert SMALL.similarity("path", CART, BOX) == 1 / 5
    # Truck and cart are two steps apart over the vehicle, whose depth is 2.
    assert SMALL.similarity("wup", TRUCK, CART) == 4 / 6
    assert SMALL.similarity("wup", CART, BOX) == 2 / 6
    assert SMALL.similarity("wup", TRUCK, TRUCK) == 1
    assert SMALL.similarity("wup", TRUCK, FEELING) == SMALL.similarity("lin", BOX, FEELING) == 0


def test_information_content_by_hand() -> None:
    # Each counts once more than it was seen: cart 6, box 4, truck 1, feeling 2. The truck
    # counts for both that it is a kind of: vehicle 1 + 6 + 1, container 1 + 4 + 1, thing 15.
    assert SMALL.information(THING) == pytest.approx(-math.log(15 / 17))
    assert SMALL.information(VEHICLE) == pytest.approx(-math.log(8 / 17))
    truck, cart = -math.log(1 / 17), -math.log(6 / 17)
    shared = -math.log(8 / 17)
    assert SMALL.similarity("lin", TRUCK, CART) == pytest.approx(2 * shared / (truck + cart))


def test_counts_may_be_absent() -> None:
    assert read_wordnet(INDEX, DATA, b"", b"").information(CART) == pytest.approx(math.log(8))


@pytest.mark.parametrize(("index", "data"), [(b"", DATA), (INDEX, b""), (INDEX, DATA[:200])])
def test_files_that_do_not_belong_together(index: bytes, data: bytes) -> None:
    with pytest.raises(ValueError, match="belong together"):
        read_wordnet(index, data, b"", b"")


@needs_wordnet
class TestPrincetonWordNet:
    """Values of WordNet 3.0 that are published for its first senses."""

    def first(self, net: WordNet, word: str) -> int:
        return net.synsets(word)[0]

    @pytest.mark.parametrize(
        ("a", "b", "path", "wup"), [("dog", "cat", 0.2, 24 / 28), ("car", "bicycle", 0.2, 18 / 22)]
    )
    def test_published_similarities(self, a: str, b: str, path: float, wup: float) -> None:
        net = wordnet()
        one, other = self.first(net, a), self.first(net, b)
        assert net.similarity("path", one, other) == pytest.approx(path)
        assert net.similarity("wup", one, other) == pytest.approx(wup)
        assert net.similarity("lin", one, other) == net.similarity("lin", other, one)
        assert 0.7 < net.similarity("lin", one, other) < 1

    @pytest.mark.parametrize(
        ("form", "lemma"),
        [("goods", "good"), ("tires", "tire"), ("boxes", "box"), ("men", "man"), ("axes", "axis"),
         ("trolleys", "trolley"), ("lorries", "lorry"), ("boxesful", "boxful"),
         ("loading docks", "loading_dock")],
    )  # fmt: skip
    def test_morphology(self, form: str, lemma: str) -> None:
        assert lemma in wordnet().lemmas(form)

    def test_ss_is_no_plural(self) -> None:
        assert wordnet().lemmas("pass") == ("pass",)


def test_where_wordnet_is_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CT_WORDNET", str(tmp_path))
    for look in (wordnet, wordnet_identity):
        with pytest.raises(ModelError, match="wordnet-base") as caught:
            look()
        assert caught.value.where == str(tmp_path)


def test_wordnet_from_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, content in (("index.noun", INDEX), ("data.noun", DATA), ("noun.exc", b"")):
        (tmp_path / name).write_bytes(content)
    monkeypatch.setenv("CT_WORDNET", str(tmp_path))
    assert wordnet().lemmas("boxes") == ("box",)
    (tmp_path / "data.noun").write_bytes(b"")
    other = tmp_path / "other"
    other.mkdir()
    for name in ("index.noun", "data.noun", "noun.exc"):
        (other / name).write_bytes(b"")
    monkeypatch.setenv("CT_WORDNET", str(other))
    with pytest.raises(ModelError, match="belong together"):
        wordnet()


def _same(one: WordNet, other: WordNet) -> bool:
    return (
        list(one.senses.items()) == list(other.senses.items())
        and dict(one.hypernyms) == dict(other.hypernyms)
        and one.exceptions == other.exceptions
        and one.frequency == other.frequency
        and all(one.information(s) == other.information(s) for s in one.hypernyms)
    )


class TestKept:
    """What was read of WordNet is kept, and is the same when it is read again."""

    @pytest.fixture
    def cache(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
        dictionary = tmp_path / "dictionary"
        dictionary.mkdir()
        files = ("index.noun", INDEX), ("data.noun", DATA), ("noun.exc", EXCEPTIONS)
        for name, content in (*files, ("cntlist.rev", COUNTS)):
            (dictionary / name).write_bytes(content)
        monkeypatch.setenv("CT_WORDNET", str(dictionary))
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
        resources._read_wordnet.cache_clear()
        yield tmp_path / "cache"
        resources._read_wordnet.cache_clear()

    def read_again(self) -> WordNet:
        resources._read_wordnet.cache_clear()
        return wordnet()

    def test_the_same_comes_back(self, cache: Path) -> None:
        assert not cache.exists()
        assert _same(wordnet(), SMALL)
        (kept,) = cache.glob("*/*.msgpack")
        before = kept.stat().st_mtime_ns
        again = self.read_again()
        assert _same(again, SMALL)
        assert again.lemmas("axes") == ("ax", "axis")
        assert len(again.senses) == 11
        assert "truck" in again.senses
        assert "bus" not in again.senses
        with pytest.raises(KeyError):
            again.senses["bus"]
        assert kept.stat().st_mtime_ns == before

    def test_a_damaged_one_is_made_again(self, cache: Path) -> None:
        wordnet()
        (kept,) = cache.glob("*/*.msgpack")
        whole = kept.read_bytes()
        for damaged in (b"", whole[:500], whole.replace(b"lorry", b"larry")):
            kept.write_bytes(damaged)
            assert _same(self.read_again(), SMALL)
            assert kept.read_bytes() == whole

    def test_nothing_need_be_kept(self, cache: Path) -> None:
        cache.write_bytes(b"no folder")
        assert _same(wordnet(), SMALL)
        assert _same(self.read_again(), SMALL)

    def test_other_files_are_another_wordnet(
        self, cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        wordnet()
        other = tmp_path / "other"
        shutil.copytree(tmp_path / "dictionary", other)
        (other / "cntlist.rev").write_bytes(b"")
        monkeypatch.setenv("CT_WORDNET", str(other))
        assert wordnet().frequency == {}
        assert len(list(cache.glob("*/*.msgpack"))) == 2


@needs_wordnet
def test_princetons_nouns_are_kept_whole(tmp_path: Path) -> None:
    whole = resources._parse_wordnet(resources._wordnet_folder())
    content = wordnet_to_bytes(whole)
    assert _same(wordnet_from_bytes(content, where="wordnet", fix=""), whole)
