"""Feed the readers of files with bytes that libFuzzer makes up from good and bad files.

    python tests/bad_input/fuzz_readers.py mesh -max_total_time=600

`mesh`, `layout` or `rig`; what follows goes to libFuzzer. A file must be read or refused with the documented
exception; anything else ends the run with the file that did it.
"""

import json
import os
import sys
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

ENDINGS = (".stl", ".ply", ".obj", ".off")


def mesh_reader(folder: Path) -> Callable[[bytes], None]:
    """The first byte says what the file is called, and whether to repair it."""
    import meshes

    paths = [folder / f"fuzzed{ending}" for ending in ENDINGS]
    warnings.simplefilter("ignore")

    def read(data: bytes) -> None:
        choice = data[0] if data else 0
        path = paths[choice % len(paths)]
        path.write_bytes(data[1:])
        try:
            mesh = meshes.load(path, repair=choice >= 128)
        except meshes.MeshError as error:
            assert str(path) in str(error), error
            return
        assert len(mesh.faces) and np.isfinite(mesh.vertices[mesh.faces]).all() and np.isfinite(mesh.area), "no mesh"
        assert mesh.area > 0, "no area"

    return read


def layout_reader(folder: Path) -> Callable[[bytes], None]:
    """The whole file."""
    import exact
    from experiments.files.errors import InputError
    from experiments.layouts import layout_file

    path = folder / "layout.json"

    def read(data: bytes) -> None:
        path.write_bytes(data)
        try:
            found = layout_file.read(path)
            found.ring.cameras(found.angles)
        except (InputError, exact.ExactError):
            return
        assert 1 <= found.demand.threshold <= len(found.angles), "threshold"
        assert found.demand.min_baseline >= 0, "baseline"

    return read


def rig_reader(folder: Path) -> Callable[[bytes], None]:
    """The whole file."""
    import exact
    import placement
    from experiments.files.errors import InputError
    from experiments.request import rig as rig_file

    path = folder / "rig.toml"

    def read(data: bytes) -> None:
        path.write_bytes(data)
        try:
            rig_file.rig(path).ring((36.0, 24.0))
        except (InputError, exact.ExactError, placement.PlacementError):
            return

    return read


def seeds(target: str) -> list[bytes]:
    """Files to begin with."""
    from tests.bad_input.cases import CASES
    from tests.support.files import ASCII, LAYOUT, PLY, box, stl

    if target == "layout":
        wanted, good = ".json", [json.dumps(LAYOUT).encode()]
    elif target == "rig":
        from experiments.request.rig_template import commented

        wanted, good = ".toml", [section.encode() for section in commented().split("\n\n")]
    else:
        obj = "v 0 0 0\nv 5 0 0\nv 0 5 0\nv 5 5 0\nf 1 2 3\nf 2//1 4/2/1 3/3\n"
        off = "OFF\n4 2 0\n0 0 0\n5 0 0\n0 5 0\n5 5 0\n3 0 1 2\n4 0 1 3 2\n"
        named = ((3, off.encode()), (0, stl(box())), (0, ASCII.encode()), (1, PLY.encode()), (2, obj.encode()))
        wanted, good = ENDINGS, [bytes([first]) + data for first, data in named]
        good.append(bytes([129]) + box().export(file_type="ply"))
    for case in CASES.values():
        with tempfile.TemporaryDirectory() as name:
            case.arguments(Path(name))
            for path in Path(name).iterdir():
                if path.is_file() and path.suffix.endswith(wanted) and path.name != "part.stl":
                    first = bytes([ENDINGS.index(path.suffix)]) if target == "mesh" else b""
                    good.append(first + path.read_bytes()[:4000])
    return good


READERS = {"mesh": mesh_reader, "layout": layout_reader, "rig": rig_reader}


def main(arguments: list[str]) -> None:
    """Run libFuzzer until it finds something, or as long as its options say."""
    import atheris

    target, *options = arguments
    parsers = {
        "mesh": ["meshes", "trimesh.exchange"],
        "layout": ["experiments", "json"],
        "rig": ["experiments", "tomllib"],
    }
    with atheris.instrument_imports(include=parsers[target]):
        import meshes  # noqa: F401
        from experiments.request import rig  # noqa: F401
    with tempfile.TemporaryDirectory(dir="/dev/shm" if os.path.isdir("/dev/shm") else None) as name:
        corpus = Path(name) / "corpus"
        corpus.mkdir()
        for number, seed in enumerate(seeds(target)):
            (corpus / str(number)).write_bytes(seed)
        atheris.Setup([sys.argv[0], "-max_len=4096", *options, str(corpus)], READERS[target](Path(name)))
        atheris.Fuzz()


if __name__ == "__main__":
    main(sys.argv[1:])
