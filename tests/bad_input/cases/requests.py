"""Rig files, options, lists of faces and output folders that cannot be used."""

import json
from collections.abc import Callable
from pathlib import Path

import exact
import placement
from experiments.files.errors import InputError
from experiments.request import rig as rig_file
from tests.bad_input.cases.case import Case
from tests.support.files import LAYOUT, made, part, put


def rig(content: bytes | str, message: str, error: type[Exception] = InputError) -> Case:
    return Case(
        lambda folder: ("optimise", part(folder), "--rig", put(folder, "rig.toml", content), "--out", folder / "out"),
        message,
        lambda folder: rig_file.rig(folder / "rig.toml").ring((36.0, 24.0)),
        error,
    )


RIGS = {
    "no rig file": Case(
        lambda folder: ("optimise", part(folder), "--rig", folder / "no.toml"),
        r"cannot read rig file .*no\.toml: No such file .*; camring rig init writes one",
        lambda folder: rig_file.read(folder / "no.toml"),
    ),
    "two rolls": rig(
        "[ring]\nroll = 'tangential'\nroll_deg = 5\n", r"roll and roll_deg in \[ring\] both say how sensors are turned"
    ),
    "roll of no kind": rig("[ring]\nroll = 'flat'\n", r"roll is 'flat'; it must be", exact.ExactError),
    "misspelt key": rig("[ring]\ndiametre = 30\n", r"no key 'diametre' in \[ring\]; did you mean diameter\?"),
    "misspelt section": rig("[camera]\ncount = 3\n", r"no section \[camera\]; did you mean \[cameras\]\?"),
    "key in the wrong section": rig("[ring]\ncount = 3\n", r"count in \[ring\] is in the wrong place; .*\[cameras\]"),
    "key twice": rig("[ring]\ndiameter = 30\ndiameter = 31\n", r"holds no valid TOML"),
    "rig of bytes": rig(b"\xff\xfe", r"rig\.toml is not a rig file: it holds no valid TOML"),
    "rig nested without end": rig("a = " + "[" * 100_000, r"rig\.toml is not a rig file: it holds no valid TOML"),
    "words for a number": rig("[ring]\ndiameter = 'wide'\n", r"diameter in \[ring\] is 'wide'; it must be a number"),
    "number of many digits": rig(f"[ring]\ndiameter = {10**400}\n", r"diameter in \[ring\] is 1000.*must be a number"),
    "digits without end": rig(f"[ring]\ndiameter = {'1' * 5000}\n", r"rig\.toml is not a rig file"),
    "a number that is none": rig(
        "[constraints]\nmin_separation = nan\n", r"min_separation .* is nan; it must be a number"
    ),
    "part of a camera": rig("[cameras]\ncount = 2.5\n", r"count in \[cameras\] is 2\.5; it must be a whole number"),
    "fixed camera at 1e300": rig("[constraints]\nfixed_deg = [1e300]\n", r"fixed .*at most", placement.PlacementError),
    "ring without width": rig("[ring]\ndiameter = 0\n", r"ring diameter is 0.*; it must be positive", exact.ExactError),
    "focus on the ring": rig(
        "[ring]\ndiameter = 1e-200\nworking_distance = 1e-200\n",
        r"diameter is 1e-200.*at least 1e-09",
        exact.ExactError,
    ),
    "ring lost in a far focus": rig("[ring]\nfocus = [0, 0, 1e18]\n", r"focus is .*at most 1e\+09", exact.ExactError),
}


def ringed(message: str, *options: object) -> Case:
    return Case(lambda folder: ("ring", part(folder), *options, "--out", folder / "rings"), message)


def evaluated(message: str, *options: object, library: Callable[[], object] | None = None) -> Case:
    return Case(
        lambda folder: ("evaluate", part(folder), *options),
        message,
        None if library is None else lambda folder: library(),
        exact.ExactError,
    )


def optimised(message: str, *options: object) -> Case:
    return Case(lambda folder: ("optimise", part(folder), "--out", folder / "out", *options), message)


OPTIONS = {
    "angle not a number": evaluated(r"--angles-deg is '0,nan'; every angle must be finite", "--angles-deg", "0,nan"),
    "angle of 1e300": evaluated(
        r"ring angle 2 is 1.*e\+\d+ rad; .*at most",
        "--angles-deg",
        "0,1e300",
        library=lambda: exact.Ring().cameras([0, 1e300]),
    ),
    "T = 0": evaluated(r"threshold is 0; it must be a whole number, at least 1", "--cameras", 2, "--threshold", 0),
    "T > M": evaluated(r"threshold is 3 with 2 cameras.*lower the threshold", "--cameras", 2, "--threshold", 3),
    "no camera to place": optimised(r"(cameras|n_cameras) is 0.*at least 1", "--cameras", 0),
    "T > M to optimise": optimised(r"threshold is 3.*2 cameras", "--cameras", 2, "--threshold", 3),
    "one number for a field of view": evaluated(r"--fov is '36'.*36x24", "--cameras", 2, "--fov", "36"),
    "words for an angle": evaluated(r"--angles-deg is '0,ninety'", "--angles-deg", "0,ninety"),
    "no layout at all": evaluated(r"exactly one way"),
    "diameters in words": ringed(r"--diameter is 'wide'; it must be lengths in millimetres", "--diameter", "wide"),
    "diameters without a step": ringed(r"--diameter is '20:40'; it must be lengths", "--diameter", "20:40"),
    "diameters that go down": ringed(r"--diameter is '40:20:5'; it must be lengths", "--diameter", "40:20:5"),
    "diameters in no steps": ringed(r"--diameter is '20:40:0'; it must be lengths", "--diameter", "20:40:0"),
    "distances without end": ringed(
        r"--working-distance is '1:9:1e-9'; .*at most 100 of them", "--working-distance", "1:9:1e-9"
    ),
    "diameter of nothing": ringed(r"ring diameter is 0.*; it must be positive", "--diameter", "0,20"),
    "fields of view in words": ringed(r"--fov is 'wide'; it must be width x height", "--fov", "36x24,wide"),
    "too many rings": ringed(
        r"these are 2500 rings; ask for at most 2000", "--diameter", "1:50:1", "--working-distance", "301:350:1"
    ),
    "rings too narrow for the cameras": ringed(
        r"none of the 2 rings can hold the cameras; of the first, 4 cameras at 5 mm need a ring of at least 7\.1 mm",
        "--diameter",
        "5,6",
    ),
    "two options of roll": evaluated(
        r"--roll and --roll-deg both say how sensors are turned", "--cameras", 2, "--roll", "radial", "--roll-deg", 5
    ),
    "negative ring diameter": evaluated(r"ring diameter is -1", "--cameras", 2, "--diameter", -1),
    "scale of 0": evaluated(r"scale is 0\.0; needed is a positive number", "--cameras", 2, "--scale", 0),
    "no camera": evaluated(r"number of cameras is 0; .*at least 1", "--cameras", 0),
    "a billion cameras": evaluated(r"number of cameras is 1000000000; .*at most", "--cameras", 10**9),
    "field of view of 0": evaluated(r"--fov is '0x24'; .*both positive", "--cameras", 2, "--fov", "0x24"),
    "negative field of view": evaluated(r"--fov is '-36x24'; .*both positive", "--cameras", 2, "--fov", "-36x24"),
    "endless field of view": evaluated(r"--fov is .*both positive", "--cameras", 2, "--fov", f"{'9' * 400}x24"),
    "ring diameter not a number": evaluated(
        r"ring diameter is nan; it must be positive and finite",
        "--cameras",
        2,
        "--diameter",
        "nan",
        library=lambda: exact.Ring(diameter=float("nan")),
    ),
    "ring in the plane of the focus": evaluated(
        r"working distance is 0.*; it must be positive",
        "--cameras",
        2,
        "--working-distance",
        0,
        library=lambda: exact.Ring(working_distance=0),
    ),
    "baseline not a number": evaluated(r"min_baseline is nan; it must be", "--cameras", 2, "--min-baseline", "nan"),
    "baseline wider than the ring": evaluated(r"no two cameras are 40 mm apart", "--cameras", 2, "--min-baseline", 40),
    "scale not a number": evaluated(r"scale is nan; needed is a positive number", "--cameras", 2, "--scale", "nan"),
    "target of 99": evaluated(r"--target is 99; it must be a fraction", "--cameras", 2, "--target", 99),
    "target not a number": evaluated(r"--target is nan; it must be a fraction", "--cameras", 2, "--target", "nan"),
    "depth of a file": evaluated(r"--depth and --detail belong to built-in sites", "--cameras", 2, "--depth", 50),
    "excluded faces not there": evaluated(
        r"--exclude is 'tpo'; it must be top, none", "--cameras", 2, "--exclude", "tpo"
    ),
    "cameras twice": evaluated(r"exactly one way", "--cameras", 2, "--angles-deg", "0,90"),
    "option misspelt": evaluated(r"No such option: --camera", "--camera", 2),
    "words for a number of cameras": evaluated(r"--cameras'?: .*valid integer", "--cameras", "two"),
    "separation not a number": optimised(r"min_separation is nan; it must be", "--min-separation", "nan"),
    "negative separation": optimised(r"min_separation is -1.*at least 0", "--min-separation", -1),
    "housings wider than the ring": optimised(
        r"12 cameras at 10 mm need a ring of at least 38\.6\d* mm; this one takes 9",
        "--cameras",
        12,
        "--min-separation",
        10,
    ),
    "a billion cameras side by side": optimised(r"1000000000; .*at most", "--cameras", 10**9, "--min-separation", 0),
    "fixed cameras in one place": optimised(
        r"fixed .*0 mm apart|at 0 mm|two fixed", "--cameras", 3, "--fixed-deg", "10,10"
    ),
    "no place left": optimised(r"forbidden", "--cameras", 3, "--forbidden-deg", "0:180,180:360"),
    "no weight at all": optimised(r"--site-weights is '0'; it must be", "--site-weights", "0"),
    "weights for more meshes": optimised(r"site_weights are .* there are 1 mesh", "--site-weights", "1,2"),
    "no objective": optimised(r"objective is 'best'; it must be", "--objective", "best"),
    "negative seed": optimised(r"seed is -1; it must be a whole number, at least 0", "--seed", -1),
    "no pose": optimised(r"poses is 0|jitter.* is 0; it must be", "--jitter", 0),
    "a tilt without end": optimised(r"tilt.* is inf", "--jitter", 2, "--tilt-deg", "inf"),
    "light that falls off at once": optimised(r"distance is 0|falloff.* is 0", "--falloff-mm", 0),
    "unknown export": optimised(r"there is no format 'colmp'.*Did you mean colmap\?", "--export", "colmp"),
}


def called(message: str, *arguments: object) -> Case:
    """A command that needs no file, or one that is sound."""
    return Case(lambda folder: [one(folder) if callable(one) else one for one in arguments], message)


def my_layout(folder: Path) -> Path:
    return put(folder, "my.json", json.dumps(LAYOUT))


COMMANDS = {
    "no such site": called(r"circ_round: neither a file nor a built-in site", "optimise", "circ_round"),
    "a depth that the site lacks": called(r"circ_flat has no depth 7", "optimise", "circ_flat", "--depth", 7),
    "a detail that no site has": called(r"no detail 'huge'", "optimise", "circ_flat", "--detail", "huge"),
    "scale of a site": called(
        r"circ_flat is in millimetres; leave the scale of 10 out",
        "evaluate",
        "circ_flat",
        "--cameras",
        2,
        "--scale",
        10,
    ),
    "layout and ring": called(
        r"a layout brings its own ring", "evaluate", "circ_flat", "--layout", my_layout, "--diameter", 20
    ),
    "one layout to compare": called(r"1 layout is given; at least two", "compare", my_layout, "--mesh", "circ_flat"),
    "site without a file": called(r"--out", "site", "circ_flat"),
    "site of another format": called(
        r"ending must be \.stl, \.ply or \.obj", "site", "circ_flat", "--out", lambda folder: folder / "a.step"
    ),
    "site that is not there": called(
        r"there is no site 'round'", "site", "round", "--out", lambda folder: folder / "a.stl"
    ),
}


def listed(name: str, content: bytes | str, message: str) -> Case:
    return Case(
        lambda folder: ("evaluate", part(folder), "--cameras", 2, "--exclude", put(folder, name, content)), message
    )


EXCLUDED = {
    "index of no face": listed("f.txt", "0\n12\n", r"f\.txt holds '12'; each line must be a face index from 0 to 11"),
    "index below 0": listed("f.txt", "-1\n", r"f\.txt holds '-1'; each line must be"),
    "index of many digits": listed("f.txt", "1" * 5000, r"f\.txt holds '111.*; each line must be"),
    "indices of bytes": listed("f.txt", b"\xff\xfe", r"--exclude is .*f\.txt'; it must be top, none, or a text file"),
}


def output(make: Callable[[Path], Path], message: str, *command: object) -> Case:
    """A place where no result can be put."""
    command = command or ("evaluate", "--cameras", 2)
    return Case(
        lambda folder: (command[0], part(folder), *command[1:], "--out", make(folder)),
        message,
    )


OUTPUTS = {
    "output folder of optimise is a file": output(
        lambda folder: put(folder, "taken", b"mine"), r"taken is a file; give another folder", "optimise"
    ),
    "output folder is a file": output(lambda folder: put(folder, "taken", b"mine"), r"taken is a file; give another"),
    "output folder below a file": output(
        lambda folder: put(folder, "taken", b"mine") / "out", r"cannot write to output folder .*out: Not a directory"
    ),
    "output folder is a dangling link": output(
        lambda folder: made(folder / "out", lambda path: path.symlink_to(folder / "gone")), r"out is .*; give another"
    ),
    "output folder of an impossible name": output(lambda folder: folder / ("o" * 300), r"File name too long; give"),
    "results are there": output(
        lambda folder: put(made(folder / "out", Path.mkdir), "evaluation.json", b"mine").parent,
        r"out already holds evaluation\.json; give another place, or --force",
    ),
    "a folder where a result belongs": output(
        lambda folder: made(folder / "out" / "evaluation.json", lambda path: path.mkdir(parents=True)).parent,
        r"evaluation\.json is a folder; move it away",
        "evaluate",
        "--cameras",
        2,
        "--force",
    ),
}
