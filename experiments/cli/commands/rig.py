"""camring rig: write a rig file to start from."""

from pathlib import Path

from experiments.files.whole import output_file, written_whole
from experiments.request.rig_template import commented
from experiments.terminal.console import note, print_json


def init(path: Path, force: bool, as_json: bool = False) -> None:
    """Write a rig file that holds every key with its default."""
    output_file(path, force)
    with written_whole(path) as temporary:
        temporary.write_text(commented(), encoding="utf-8")
    if as_json:
        print_json({"files": [str(path)]})
    note(f"wrote {path}; give it with --rig {path}")
