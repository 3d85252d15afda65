"""What a report says of the request: what was asked, and how to get the same layout again."""

import shlex
from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

import exact
import placement
from experiments.layouts.rings_content import MOST_CAMERAS
from experiments.request.options import PARTS, keys, sections
from experiments.request.rig import MOST
from experiments.request.rig_template import toml_value
from meshes import EXPECTED

# Angles in degrees are written with so many digits after the point: less than a micrometre on any ring.
DIGITS = 9


class Made(NamedTuple):
    """A layout, on one ring or several, with what it was made for."""

    content: dict[str, Any]
    """All that `camring optimise` or `camring count` writes."""
    rings: tuple[exact.Ring, ...]
    """On which cameras may sit."""
    demand: exact.Demand
    """What makes a point count."""


def asked(made: Made) -> list[tuple[str, str]]:
    """What was asked, as rows of a table: what, and the answer in words."""
    content, limits = made.content, made.content["constraints"]
    several = len(content["meshes"]) > 1
    names = [
        f"{mesh['name']}{f', weight {weight:g}' if several else ''}; not counted: {mesh['excluded']}"
        for mesh in content["meshes"]
        for weight in [mesh["weight"]]
    ]
    rows = [
        ("meshes" if several else "mesh", "; ".join(names)),
        ("cameras", str(content["n_cameras"])),
        ("a point counts when", made.demand.clause()),
        *_ring_rows(made),
        ("smallest separation", f"{limits['min_separation']:g} mm"),
    ]
    if content.get("lights"):
        rows.append(("lights", "; ".join(f"{_vector(light)} mm" for light in content["lights"])))
    if content.get("obstacles"):
        rows.append(("obstacles", f"{len(content['obstacles'])}, which hide and do not count"))
    if content.get("give_up"):
        maximum = "the ring maximum" if len(made.rings) == 1 else "what all rings see"
        rows.append(("given up for accuracy", f"at most {100 * content['give_up']:g} % of {maximum}"))
    if limits["fixed"]:
        rows.append(("fixed cameras", ", ".join(f"{angle:g}°" for angle in _degrees(limits["fixed"]))))
    if limits["forbidden"]:
        arcs = (_degrees(arc) for arc in limits["forbidden"])
        rows.append(("forbidden arcs", ", ".join(f"{start:g}° to {end:g}°" for start, end in arcs)))
    if several or content["poses"]:
        worst = content["objective"] == "worst"
        rows.append(("maximised", "the fraction of the worst" if worst else "the mean fraction of all"))
    if content["poses"]:
        poses = content["poses"]
        rows.append(
            ("poses of each mesh", f"{poses['n']}: as it is, and up to {poses['tilt_deg']:g}° tilted, "
             f"{poses['shift_mm']:g} mm shifted")
        )  # fmt: skip
    if content["falloff_mm"] is not None:
        rows.append(("weight of a face", f"half at {content['falloff_mm']:g} mm from the focus, 1/16 at twice as far"))
    return rows


def _ring_rows(made: Made) -> list[tuple[str, str]]:
    rows = []
    for number, ring in enumerate(made.rings):
        width, height = ring.fov
        words = [
            f"{ring.diameter:g} mm wide, {ring.working_distance:g} mm from the focus at {_vector(ring.focus)} mm",
            f"field of view {width:g} x {height:g} mm at the focus",
        ]
        if tuple(ring.axis) != (0.0, 0.0, 1.0):
            words.append(f"axis {_vector(ring.axis)}")
        if ring.zero_towards is not None:
            words.append(f"ring angle 0 towards {_vector(ring.zero_towards)}")
        if ring.roll != "radial":
            words.append(f"sensors {roll_words(ring)}")
        if (most := _most(made, number)) is not None:
            words.append(f"at most {most} of the cameras")
        rows.append(("ring" if len(made.rings) == 1 else f"ring {number + 1}", "; ".join(words)))
    return rows


def _most(made: Made, number: int) -> int | None:
    """The most cameras that one of several rings takes."""
    return made.content["rings"][number][MOST_CAMERAS] if len(made.rings) > 1 else None


def roll_words(ring: exact.Ring) -> str:
    """How the sensors of a ring are turned about their optical axes.

    Examples
    --------
    >>> roll_words(exact.Ring(roll="tangential")), roll_words(exact.Ring(roll=np.pi / 6))
    ('tangential', 'the width of every image along ring angle 30°')
    """
    if isinstance(ring.roll, str):
        return ring.roll
    return f"the width of every image along ring angle {_degrees([ring.roll])[0]:g}°"


def command(made: Made) -> str:
    """The command line that asks for the same again, with `rig` as rig.toml."""
    return shlex.join(["camring", "optimise", *_mesh_words(made.content["meshes"]), "--rig", "rig.toml", "--report"])


def evaluation(made: Made) -> str:
    """The command line that gives the area of exactly this layout on its first mesh, with `rig` as rig.toml."""
    mesh, content = _mesh_words(made.content["meshes"][:1]), made.content
    if len(made.rings) > 1 or "rolls_rad" in content:
        file = "several_rings.json" if len(made.rings) > 1 else "layout.json"
        return shlex.join(["camring", "evaluate", *mesh, "--layout", file])
    angles = ",".join(str(angle) for angle in _degrees(content["angles_rad"]))
    return shlex.join(["camring", "evaluate", *mesh, "--rig", "rig.toml", "--angles-deg", angles])


def _mesh_words(meshes: Sequence[dict[str, Any]]) -> list[str]:
    """How a command names meshes: sites by name, depth and detail."""
    known = [_built_in(mesh["sha256"]) for mesh in meshes]
    words = [
        mesh["name"] if site is None else f"{site[0]}@{site[1]:g}" for mesh, site in zip(meshes, known, strict=True)
    ]
    details = [site[2] for site in known if site is not None]
    return [*words, *(["--detail", details[0]] if details else [])]


def rig(made: Made) -> str:
    """The rig file that asks for the same again: every key that is not at its default, and the rings in full."""
    content, limits = made.content, made.content["constraints"]
    first, poses = content["meshes"][0], content["poses"] or {"n": 1}
    weights = [mesh["weight"] for mesh in content["meshes"]]
    values: dict[str, Any] = {
        "count": content["n_cameras"],
        **_demanded(made),
        "give_up": content.get("give_up", 0.0),
        "light": content.get("lights") or None,
        "min_separation": limits["min_separation"],
        "min_baseline": limits["min_baseline"],
        "min_angle_deg": _degrees([limits["min_angle"]])[0],
        "fixed_deg": tuple(_degrees(limits["fixed"])),
        "forbidden_deg": tuple(tuple(_degrees(arc)) for arc in limits["forbidden"]),
        "seed": content["seed"],
        "certify": content["certificate"] is not None,
        "exclude": _exclusion(first["excluded"]),
        "scale": max(mesh["scale"] for mesh in content["meshes"]),
        **{name: any(mesh.get(name) for mesh in content["meshes"]) for name in ("repair", "two_sided")},
        "objective": content["objective"],
        "site_weights": weights if len(set(weights)) > 1 else None,
        "falloff_mm": content["falloff_mm"],
        "jitter": poses["n"],
        **{name: poses[name] for name in ("tilt_deg", "shift_mm") if name in poses},
        **{field.name: content["settings"].get(field.name) for field in fields(placement.Settings)},
    }
    lines = []
    for number, ring in enumerate(made.rings):
        most = _most(made, number)
        written = [f"{name} = {toml_value(value)}" for name, value in _of_ring(ring).items() if value is not None]
        lines += ["", "[ring]" if len(made.rings) == 1 else "[[ring]]", *written]
        lines += [] if most is None else [f"{MOST} = {most}"]
    for section, known in sections().items():
        written = [
            f"{name} = {toml_value(values[name])}"
            for name, key in known.items()
            if values.get(name) is not None and (section == "cameras" or _plain(values[name]) != _plain(key.default))
        ]
        lines += ["", f"[{section}]", *written] if written else []
    return "\n".join(lines[1:])


def _of_ring(ring: exact.Ring) -> dict[str, Any]:
    """What a section about a ring says, by the names of its keys; None for what it leaves out."""
    return {
        "diameter": ring.diameter,
        "working_distance": ring.working_distance,
        "fov": ring.fov,
        "focus": ring.focus,
        "axis": ring.axis,
        "zero_towards": ring.zero_towards,
        **({"roll": ring.roll} if isinstance(ring.roll, str) else {"roll_deg": _degrees([ring.roll])[0]}),
    }


def _demanded(made: Made) -> dict[str, Any]:
    """What makes a point count, by the names of the keys."""
    demand = made.demand if made.demand.depth_axis != made.rings[0].axis else replace(made.demand, depth_axis=None)
    parts = {"Demand": demand} | {kind: getattr(demand, name) for name, kind in PARTS["Demand"].items()}
    values = {}
    for kind, part in parts.items():
        for key in keys(kind).values():
            if kind in key.classes:
                value = getattr(part, key.field)
                values[key.name] = _degrees([value])[0] if key.in_degrees and value is not None else value
    return values


def _exclusion(words: str) -> str:
    """The value of the key `exclude` for what the layout file says of it."""
    if words == "nothing":
        return "none"
    return "top" if words.startswith("the top surface") else words.partition(" listed in ")[2].rpartition(", ")[0]


def _built_in(sha256: str) -> tuple[str, float, str] | None:
    """Name, depth and detail of the built-in site with this fingerprint."""
    return next((key for key, known in EXPECTED.items() if known.fingerprint == sha256), None)


def _plain(value: Any) -> Any:
    """Tuples as lists, as JSON has them."""
    return [_plain(one) for one in value] if isinstance(value, list | tuple) else value


def _degrees(angles) -> list[float]:
    return [round(float(angle), DIGITS) for angle in np.degrees(angles)]


def _vector(value) -> str:
    return f"({', '.join(f'{part:g}' for part in value)})"
