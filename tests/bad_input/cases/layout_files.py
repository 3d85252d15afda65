"""Layout files that cannot be used."""

import json

from experiments.layouts import layout_file
from tests.bad_input.cases.case import Case
from tests.support.files import LAYOUT, RING, part, put


def layout(message: str, *without: str, **changes: object) -> Case:
    """A layout file of which some fields are other than they should be, or not there."""
    content = {name: value for name, value in (LAYOUT | changes).items() if name not in without}
    return layout_text(json.dumps(content), message)


def layout_text(content: bytes | str, message: str) -> Case:
    return Case(
        lambda folder: ("evaluate", part(folder), "--layout", put(folder, "my.json", content)),
        message,
        lambda folder: layout_file.read(folder / "my.json"),
    )


def ring(**changes: object) -> dict[str, object]:
    return RING | changes


LAYOUTS = {
    "no layout file": Case(
        lambda folder: ("evaluate", part(folder), "--layout", folder / "my.json"),
        r"cannot read layout .*my\.json: No such file",
        lambda folder: layout_file.read(folder / "my.json"),
    ),
    "layout is a folder": Case(
        lambda folder: ("evaluate", part(folder), "--layout", folder),
        r"cannot read layout .*: Is a directory",
        layout_file.read,
    ),
    "layout cut short": layout_text(json.dumps(LAYOUT)[:-9], r"my\.json is not a layout file: it holds no valid JSON"),
    "layout of bytes": layout_text(b"\xff\xfe\x00", r"holds no valid JSON"),
    "layout nested without end": layout_text("[" * 200_000, r"holds no valid JSON"),
    "layout number of many digits": layout_text(
        json.dumps(LAYOUT).replace("180", "1" * 5000), r"my\.json is not a layout file: it holds no valid JSON"
    ),
    "layout is a list": layout_text("[1, 2]", r'is not a layout file: "format" must be "camring layout"'),
    "layout is another file": layout_text('{"name": "box"}', r'"format" must be .*camring optimise writes one'),
    "layout of a newer version": layout(r"has layout version 2; only 1 is known: update camring", version=2),
    "layout without version": layout(r"has layout version None; only 1 is known", "version"),
    "layout version true": layout(r"has layout version True; only 1 is known", version=True),
    "layout without ring": layout(r'my\.json: "ring" must give diameter_mm', "ring"),
    "layout with half a ring": layout(
        r'"ring" must give diameter_mm, working_distance_mm and fov_mm', ring={"fov_mm": 1}
    ),
    "layout with a word for a diameter": layout(
        r"diameter.* is 'wide'; it must be a number", ring=ring(diameter_mm="wide")
    ),
    "layout with a truth for a diameter": layout(
        r"diameter.* is True; it must be a number", ring=ring(diameter_mm=True)
    ),
    "layout with no diameter at all": layout(r"diameter.* is 0; it must be positive", ring=ring(diameter_mm=0)),
    "layout of a ring beyond the moon": layout(
        r"diameter is 1e\+300 mm; .*at most 1e\+09", ring=ring(diameter_mm=1e300)
    ),
    "layout of a ring of many digits": layout(
        r"working distance is inf; it must be positive and finite", ring=ring(working_distance_mm=10**400)
    ),
    "layout with a negative field of view": layout(
        r"fov height is -24.*; it must be positive", ring=ring(fov_mm=[36, -24])
    ),
    "layout with one number for a field of view": layout(r"fov is 36; it must be 2", ring=ring(fov_mm=36)),
    "layout with an infinite focus": layout(
        r"focus is .*; it must be 3 finite numbers", ring=ring(focus_mm=[0, 0, float("inf")])
    ),
    "layout with no axis": layout(r"ring axis is the zero vector", ring=ring(axis=[0, 0, 0])),
    "layout with a word for a roll": layout(
        r"roll is 'flat'; it must be \"radial\", .* or a number", ring=ring(roll="flat")
    ),
    "layout with too few rolls": layout(r"rolls are .*; they must be 2 numbers, one for each camera", rolls_deg=[1.0]),
    "layout with words for rolls": layout(r'"rolls_rad" must be a list of at least one number', rolls_rad=["a", "b"]),
    "layout rolls that disagree": layout(
        r'"rolls_deg" and "rolls_rad" are not the same angles', rolls_deg=[0, 90], rolls_rad=[0, 1]
    ),
    "layout roll not a number": layout(r"rolls .* not all finite", rolls_deg=[0, float("nan")]),
    "layout with a misspelt part of a ring": layout(
        r"there is no field 'focus' in \"ring\"; did you mean focus_mm\?", ring=ring(focus=[0, 0, 1])
    ),
    "layout with a misspelt field": layout(r"there is no field 'treshold'; did you mean threshold\?", treshold=1),
    "layout without angles": layout(r"gives no ring angles", "angles_deg"),
    "layout without any angle": layout(r'"angles_deg" must be a list of at least one number', angles_deg=[]),
    "layout with words for angles": layout(r'"angles_deg" must be a list', angles_deg=["north", "south"]),
    "layout with one number for angles": layout(r'"angles_rad" must be a list', angles_rad=1.0),
    "layout angle not a number": layout(r"ring angles .* finite", angles_deg=[0, float("nan")]),
    "layout angle of 1e300": layout(r"ring angle 2 is 1\.7.*e\+298 rad; .*at most", angles_deg=[0, 1e300]),
    "layout angle of many digits": layout(r"ring angles?.*", angles_deg=[0, 10**400]),
    "layout angles that disagree": layout(
        r'"angles_deg" and "angles_rad" are not the same angles; leave one of them out', angles_rad=[0.0, 3.0]
    ),
    "layout of another number of cameras": layout(r'"n_cameras" is 3, and there are 2 ring angles', n_cameras=3),
    "layout with T = 0": layout(r'"threshold" is 0; it must be a whole number from 1 to 2', threshold=0),
    "layout with T > M": layout(r'"threshold" is 3; it must be a whole number from 1 to 2', threshold=3),
    "layout with half a threshold": layout(r'"threshold" is 1\.5; it must be', threshold=1.5),
    "layout with constraints of another kind": layout(r'"constraints" is \[5\]; it must give some of', constraints=[5]),
    "layout with a misspelt constraint": layout(
        r'"constraints" is .*min_separaton.*; it must give some of fixed, forbidden', constraints={"min_separaton": 1}
    ),
    "layout with a negative baseline": layout(r"min_baseline is -1", constraints={"min_baseline": -1}),
    "layout with a word for a baseline": layout(r"min_baseline is 'no'", constraints={"min_baseline": "no"}),
    "layout with a baseline wider than the ring": layout(
        r"no two cameras are 31 mm apart on a ring of 30 mm", constraints={"min_baseline": 31}
    ),
    "layout with a mesh of another kind": layout(r'"mesh" is .*; it must give .*sha256', mesh=["a.stl"]),
    "layout made for another mesh": Case(
        lambda folder: (
            "evaluate",
            part(folder),
            "--layout",
            put(folder, "my.json", json.dumps(LAYOUT | {"mesh": {"name": "other.stl", "sha256": "0" * 64}})),
        ),
        r"my\.json was made for 'other\.stl', and part\.stl is not the same mesh; give that one, or --force",
    ),
    "layouts made for another mesh": Case(
        lambda folder: (
            "compare",
            put(folder, "a.json", json.dumps(LAYOUT)),
            put(folder, "b.json", json.dumps(LAYOUT | {"mesh": {"name": "other.stl", "sha256": "0" * 64}})),
            "--mesh",
            part(folder),
        ),
        r"b\.json was made for 'other\.stl', and part\.stl is not the same mesh; give that one, or --force",
    ),
}
