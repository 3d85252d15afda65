"""What `camring --help` says and costs, and what the shell completes."""

import json
import re
import shlex
import subprocess
import sys

import pytest
import trimesh
import typer

import meshes
from experiments.cli import app as cli
from experiments.cli import options
from experiments.request import options as request_options

HEAVY = {"numpy", "jax", "scipy", "shapely", "trimesh", "matplotlib", "plotly", "placement", "exact", "meshes"}
# They take minutes to hours, or until they are stopped: what they do is tested elsewhere, and here they need only be
# understood.
SLOW = ("camring bench", "camring design", "camring paper", "camring simulate", "camring study")


def commands(command=None, words=()):
    """Every subcommand with the words that call it."""
    command = typer.main.get_command(cli.app) if command is None else command
    if not hasattr(command, "commands"):
        return {words: command}
    return {w: c for name, sub in command.commands.items() for w, c in commands(sub, (*words, name)).items()}


COMMANDS = commands()


def imported(folder, *commands):
    """What a process prints that runs these commands of camring, and the packages it has imported."""
    program = f"""
import json, sys
from experiments.cli.app import main
for arguments in {[list(words) for words in commands]!r}:
    try:
        main(arguments)
    except SystemExit as end:
        assert not end.code, arguments
print(json.dumps(sorted({{name.split(".")[0] for name in sys.modules}})))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=folder)
    return done.stdout, set(json.loads(done.stdout.splitlines()[-1]))


def test_help_imports_nothing_heavy(tmp_path):
    said, packages = imported(tmp_path, ["--help"], *([*words, "--help"] for words in COMMANDS))
    assert "Usage: camring optimise" in said
    assert not HEAVY & packages


def examples(words):
    return re.findall(r"^(?:Example: |   *)(camring .*)$", COMMANDS[words].help or "", flags=re.M)


@pytest.fixture(scope="module")
def desk(tmp_path_factory, quick_search):
    """A folder with what the examples take for granted: a mesh and layouts of it."""
    folder = tmp_path_factory.mktemp("desk")
    step = trimesh.boolean.union(
        [trimesh.creation.box((30, 30, 2)), trimesh.creation.box((4, 30, 20))], engine="manifold"
    )
    step.export(folder / "scan.stl")
    (folder / "quick.toml").write_text(quick_search, encoding="utf-8")
    content = {
        "format": "camring layout",
        "version": 1,
        "ring": {"diameter_mm": 30, "working_distance_mm": 400, "fov_mm": [36, 24]},
    }
    for name, angles in (("a", [0, 120, 240]), ("b", [0, 90, 180])):
        (folder / name).mkdir()
        text = json.dumps(content | {"angles_deg": angles, "constraints": {"min_separation": 5.0, "min_angle": 0.01}})
        (folder / name / "layout.json").write_text(text, encoding="utf-8")
    return folder


def test_what_does_not_search_does_not_import_jax(desk):
    layouts, mesh = ("a/layout.json", "b/layout.json"), ("--mesh", "scan.stl")
    _, packages = imported(
        desk,
        ("evaluate", "scan.stl", "--cameras", "3", "--json"),
        ("compare", *layouts, *mesh),
        ("export", layouts[0], "--format", ",".join(options.FORMATS), *mesh, "--out", "exported"),
        ("site", "circ_flat", "--out", "flat.stl"),
        ("rig", "init", "every_setting.toml"),
    )
    assert "placement" in packages
    assert not {"jax", "equinox", "optimistix"} & packages


def test_every_subcommand_has_an_example_and_all_of_them_work(desk, monkeypatch, capsys):
    monkeypatch.chdir(desk)
    for words in COMMANDS:
        found = examples(words)
        assert found, f"camring {' '.join(words)} --help shows no example"
        for example in found:
            arguments = shlex.split(example)[1:]
            assert tuple(arguments[: len(words)]) == words, example
            if example.startswith(SLOW):
                arguments = [*arguments, "--help"]
            elif "rig" in [parameter.name for parameter in COMMANDS[words].params]:
                arguments = [*arguments, "--rig", "quick.toml"]
            with pytest.raises(SystemExit) as end:
                cli.main(arguments)
            assert not end.value.code, (example, capsys.readouterr().err)


@pytest.mark.parametrize("words", [words for words in COMMANDS if "rig" in [p.name for p in COMMANDS[words].params]])
def test_defaults_shown_are_those_that_hold(words):
    shown = {p.name: p for p in COMMANDS[words].params}
    checked = 0
    for name, option in shown.items():
        key = request_options.keys().get("count" if name == "cameras" else name)
        if key is None or option.show_default in (True, None) or key.default is None:
            continue
        assert option.default is None, f"--{name}: its own default would win over a rig file"
        default = key.default
        if isinstance(default, bool):
            assert option.show_default == (name if default else "no")
        elif default == ():
            assert option.show_default == "none"
        elif isinstance(default, str):
            assert option.show_default == default
        elif isinstance(default, tuple):
            assert option.show_default == ",".join(f"{number:g}" for number in default)
        else:
            assert float(option.show_default) == default, name
        checked += 1
    assert checked >= 4


def test_every_subcommand_has_results_for_scripts():
    for words, command in COMMANDS.items():
        assert "--json" in [option for parameter in command.params for option in parameter.opts], words


def complete(monkeypatch, capsys, line):
    """What the shell (bash) offers for the last word of the line."""
    words = line.split(" ")
    monkeypatch.setenv("_CAMRING_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(words) - 1))
    with pytest.raises(SystemExit):
        cli.main([])
    return capsys.readouterr().out.split()


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("camring optimise circ_a", {"circ_angled", "circ_artery"}),
        ("camring evaluate spine", {"spine_disc"}),
        ("camring site ", set(meshes.SITES)),
        ("camring compare a.json --mesh ell", {"elliptical"}),
        ("camring optimise circ_flat --detail ", set(meshes.DETAILS)),
        ("camring optimise circ_flat --exclude t", {"top"}),
        ("camring optimise my_scan", set()),  # the shell itself then offers files
        ("camring optimise x --min-b", {"--min-baseline"}),
        ("camring rig i", {"init"}),
    ],
)
def test_the_shell_completes(monkeypatch, capsys, line, offered):
    assert set(complete(monkeypatch, capsys, line)) == offered


def test_names_to_complete_are_all_names():
    assert set(options.SITES) == set(meshes.SITES)
    assert set(options.DETAILS) == set(meshes.DETAILS)
    for what in options.BENCHMARKS:
        assert what in COMMANDS["bench",].params[0].help


def test_completion_can_be_installed(capsys):
    with pytest.raises(SystemExit) as end:
        cli.main(["--help"])
    assert not end.value.code
    shown = capsys.readouterr().out
    assert "--install-completion" in shown
    assert "--show-completion" in shown
