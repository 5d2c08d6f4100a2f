from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import click
import pytest

from corpus_tools import __version__
from corpus_tools.cli.console import MOST_LINES, cli, run
from g3.errors import FormatError, ManyError
from tests.processes import python

CT = Path(sys.executable).with_name("ct")
PUT = "EVENT_1(r = Put, l = OBJ_2(f = the pallet), l2 = PLACE_3(r = on, l = OBJ_4(f = the truck)))"


def ct(*args: str, **options) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [CT, *args],
        check=False,
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=60,
        **options,
    )


@pytest.fixture
def plugins(tmp_path):
    """An environment with a distribution that adds good and broken commands."""
    (tmp_path / "my_commands.py").write_text(
        "import os, signal\n"
        "import click\n"
        "from g3.errors import FormatError\n"
        "@click.command()\n"
        "def hello():\n"
        "    'Greet.'\n"
        "    click.echo('hello')\n"
        "@click.command()\n"
        "def bug():\n"
        "    raise KeyError('oh\\nno')\n"
        "@click.command()\n"
        "def bad():\n"
        "    raise FormatError('two\\nlines', where='a.json', fix='mend it')\n"
        "@click.command()\n"
        "def stop():\n"
        "    os.kill(os.getpid(), signal.SIGINT)\n"
        "@click.command()\n"
        "def much():\n"
        "    for i in range(100_000): click.echo('word')\n"
        "number = 3\n"
    )
    info = tmp_path / "my_commands-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: my-commands\nVersion: 1.0\n")
    names = ["hello", "bug", "bad", "stop", "much", "number", "missing"]
    (info / "entry_points.txt").write_text(
        "[ct.commands]\n" + "".join(f"{name} = my_commands:{name}\n" for name in names)
    )
    return {**os.environ, "PYTHONPATH": str(tmp_path)}


def test_help_lists_the_commands():
    result = ct("--help")
    assert result.returncode == 0
    assert "Examples:" in result.stdout
    for name in ("corpus", "eval", "features", "graph", "import", "train"):
        assert f"\n  {name} " in result.stdout
    assert ct("-h").stdout == result.stdout


def test_help_loads_no_heavy_module():
    code = (
        "import sys; from corpus_tools.cli.console import run; run(['--help']);"
        "print({'numpy', 'scipy', 'pandas', 'matplotlib', 'rich'} & sys.modules.keys())"
    )
    result = python("-c", code)
    assert result.stdout.endswith("set()\n"), result.stdout


def test_version():
    assert ct("--version").stdout == f"ct, version {__version__}\n"


def test_python_m():
    assert python("-m", "corpus_tools", "--version").stdout == f"ct, version {__version__}\n"


def commands() -> list[tuple[str, click.Command]]:
    found = []

    def walk(name: str, command: click.Command) -> None:
        found.append((name, command))
        if isinstance(command, click.Group):
            with click.Context(command) as ctx:
                for sub in command.list_commands(ctx):
                    child = command.get_command(ctx, sub)
                    assert child is not None
                    if not child.hidden:  # an old name: its help shows the new one
                        walk(f"{name} {sub}", child)

    walk("ct", cli)
    return found


@pytest.mark.parametrize(("name", "command"), [pytest.param(n, c, id=n) for n, c in commands()])
def test_every_command_has_help_with_an_example(name, command):
    with click.Context(command, info_name=name) as ctx:
        text = command.get_help(ctx)
    assert command.get_short_help_str(), f"{name} has no help"
    assert "can't be loaded" not in command.get_short_help_str()
    assert "Example" in text, text
    assert f"  {name} " in text, text


@pytest.mark.parametrize(("name", "command"), [pytest.param(n, c, id=n) for n, c in commands()])
def test_every_option_has_help(name, command):
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            assert parameter.help, f"{name} {parameter.opts[0]} has no help"


@pytest.mark.parametrize(
    ("name", "group"),
    [pytest.param(n, c, id=n) for n, c in commands() if isinstance(c, click.Group)],
)
def test_every_group_lists_its_commands_in_whole_lines_of_80_columns(name, group):
    with click.Context(group, info_name=name, terminal_width=80) as ctx:
        lines = group.get_help(ctx).splitlines()
        subs = {sub: group.get_command(ctx, sub) for sub in group.list_commands(ctx)}
        helps = {s: c.get_short_help_str(1000) for s, c in subs.items() if not c.hidden}
    for sub, summary in helps.items():
        listed = [line for line in lines if line.startswith(f"  {sub} ")]
        assert any(line.endswith(f"  {summary}") for line in listed), (
            f"`{name} --help` cuts off what {sub} does: shorten its first sentence or short_help"
        )
    beginnings = tuple(f"  {sub} " for sub in helps)
    assert all(len(line) <= 80 for line in lines if line.startswith(beginnings))


@pytest.mark.parametrize("args", [("nonsense",), ("graph", "--nonsense"), ("graph",)])
def test_wrong_usage_exits_2(args, capsys):
    assert run(args) == 2
    told = capsys.readouterr().err
    assert "Usage: ct" in told
    assert "Traceback" not in told


@pytest.mark.parametrize(
    ("args", "meant"),
    [
        (["evl"], "'eval'"),
        (["scenarios", "shw"], "'show'"),
        (["annotate", "inti"], "'init'"),
        (["annotate", "people", "lst"], "'list'"),
        (["import", "slucore"], "'slu-core'"),
        (["follow", "--scenari", "x"], "'--scenario'"),
    ],
)
def test_mistyped_commands_and_options_are_suggested_at_every_level(args, meant, capsys):
    assert run(args) == 2
    assert f"Did you mean {meant}?" in capsys.readouterr().err


def test_help_is_a_command_too(capsys):
    for words in (["eval", "table1"], []):
        shown = []
        for call in (["help", *words], [*words, "--help"]):
            assert run(call) == 0
            shown.append(capsys.readouterr().out)
        assert shown[0] == shown[1] != ""
    assert run(["help", "evl"]) == 2
    assert "Did you mean 'eval'?" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("args", "remedy"),
    [
        (["follow", "pick", "up", "the", "box"], "ct follow 'pick up the box'"),
        (["parse", "put", "it", "down", "--json"], "ct parse 'put it down'"),
        (["corpus", "show", "warehouse", "--verbose"], "ct --verbose ..."),
    ],
)
def test_what_is_in_the_wrong_place_is_answered_with_what_to_write(args, remedy, capsys):
    assert run(args) == 2
    assert remedy in capsys.readouterr().err


def test_graph_as_text():
    assert ct("graph", PUT).stdout.splitlines() == [
        'Ψ_1(φ_1, λ_1^r = "Put", γ_1, γ_2, γ_3)',
        'Ψ_2(φ_2, λ_2^f = "the pallet", γ_2)',
        'Ψ_3(φ_3, λ_3^r = "on", γ_3, γ_4)',
        'Ψ_4(φ_4, λ_4^f = "the truck", γ_4)',
    ]


def test_graph_from_standard_input_as_dot():
    result = ct("graph", "-", "--format", "dot", input=PUT)
    assert result.stdout.startswith("graph grounding_graph {\n")


def test_graph_from_a_file_to_a_file(tmp_path, capsys):
    source, out = tmp_path / "put.sdc", tmp_path / "put.svg"
    source.write_text(PUT, encoding="utf-8")
    out.write_text("old")
    assert run(["graph", "--file", str(source), "--format", "svg", "--out", str(out)]) == 0
    assert capsys.readouterr() == ("", "")
    assert out.read_text(encoding="utf-8").startswith("<svg ")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["put.sdc", "put.svg"]


def test_graph_on_a_terminal_without_greek():
    result = ct("graph", "OBJ(f = it)", env={**os.environ, "PYTHONIOENCODING": "latin-1"})
    assert result.stdout == '\\u03a8_1(\\u03c6_1, \\u03bb_1^f = "it", \\u03b3_1)\n'


def test_bad_input_is_one_line_and_exits_2(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.sdc").write_bytes(b"OBJ(f = \xff)")
    (tmp_path / "open.sdc").write_text("OBJ(f = it")
    cases = {
        ("graph", "EVENT("): "ct: error: column 7: expected a field: f, r, l or l2, but the",
        ("graph", ""): "ct: error: there are no clauses",
        ("graph", PUT, "--command", "Put it"): "ct: error: column 32: the word 'the' is not in",
        ("graph", "--file", "no/file"): "ct: error: no/file: No such file or directory",
        ("graph", "--file", "."): "ct: error: .: Is a directory",
        ("graph", "--file", "bad.sdc"): "ct: error: bad.sdc:1:9: byte 9 is not UTF-8",
        ("graph", "--file", "open.sdc"): "ct: error: open.sdc, column 11: expected ',' or ')'",
        ("graph", PUT, "--out", "no/file"): f"ct: error: {tmp_path}/no: there is no such folder",
    }
    for args, message in cases.items():
        assert run(args) == 2, args
        told = capsys.readouterr().err
        assert told.startswith(message), told
        assert told.count("\n") == 1
    result = ct("graph", "EVENT(")
    assert (result.returncode, result.stderr.count("\n")) == (2, 1)


def test_many_errors_are_a_line_each(monkeypatch, capsys):
    def fail(errors):
        monkeypatch.setattr(cli, "main", lambda *_, **__: (_ for _ in ()).throw(ManyError(errors)))
        assert run([]) == 2
        return capsys.readouterr().err.splitlines()

    two = [FormatError("no\nname", where="a.yaml:1:7", fix="name it"), FormatError("no title")]
    told = ["ct: error: 2 things are wrong:", "  a.yaml:1:7: no name (name it)", "  no title"]
    assert fail(two) == told
    assert len(fail(two * 100)) == MOST_LINES + 2
    assert fail(two * 100)[-1] == f"  and {200 - MOST_LINES} more"


def test_verbose_shows_the_traceback():
    result = ct("--verbose", "graph", "EVENT(")
    assert result.returncode == 2
    assert "Traceback (most recent call last)" in result.stderr
    assert result.stderr.splitlines()[-1].startswith("ct: error: column 7:")


def test_other_distributions_add_commands(plugins):
    assert ct("hello", env=plugins).stdout == "hello\n"
    lines = ct("--help", env=plugins).stdout.splitlines()
    assert ["hello", "Greet."] in [line.split() for line in lines]


def test_a_broken_command_leaves_the_others_alone(plugins):
    listing = ct("--help", env=plugins)
    assert listing.returncode == 0
    lines = [" ".join(line.split()) for line in listing.stdout.splitlines()]
    assert any(line.startswith("missing (can't be loaded: Attribute") for line in lines)
    result = ct("missing", "--help", "x", "-y", env=plugins)
    assert result.returncode == 2
    assert result.stderr.startswith("ct: error: the command missing can't be loaded: AttributeErr")
    assert "(reinstall or remove the package my-commands)" in result.stderr
    assert "my_commands:number is not a click command" in ct("number", env=plugins).stderr
    assert ct("graph", PUT, env=plugins).returncode == 0


def test_errors_of_any_command_are_one_line(plugins):
    result = ct("bad", env=plugins)
    assert (result.returncode, result.stderr) == (2, "ct: error: a.json: two lines (mend it)\n")


def test_an_unexpected_error_exits_1(plugins):
    result = ct("bug", env=plugins)
    assert result.returncode == 1
    assert result.stderr.startswith("ct: unexpected error: KeyError")
    assert "run with --verbose for the traceback, please report" in result.stderr
    assert result.stderr.count("\n") == 1
    assert "Traceback" in ct("--verbose", "bug", env=plugins).stderr


@pytest.mark.skipif(os.name == "nt", reason="POSIX signals")
def test_an_interrupt_exits_130(plugins):
    result = ct("stop", env=plugins)
    assert result.returncode == 128 + signal.SIGINT
    assert "Traceback" not in result.stderr


def test_a_reader_that_goes_away_is_no_error(plugins):
    with subprocess.Popen(
        [CT, "much"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=plugins
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        process.stdout.close()
        assert process.stderr.read() == b""
