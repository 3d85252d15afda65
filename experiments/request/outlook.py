"""What a ring sees of a mesh, and a warning where the answer is likely not what is meant."""

from dataclasses import dataclass

import numpy as np
import trimesh

import exact
from meshes.condition.facing import Cone, Facing, facing
from meshes.condition.neighbours import bodies
from meshes.condition.winding import inwards
from meshes.load import UNITS, other_units, unit_hint

# Cameras from which the surface is looked at, whatever layout it is for.
PLACES = 8
# Of the surface that faces the ring so much may be its back [parts], such as over the rim of an open scan; and a part
# of the mesh that shows its back matters if it is so much of it.
BACK, PART_AWAY = 0.05, 0.002
# Of a mesh less than this part in view is likely a mesh in another unit or place.
IN_VIEW = 0.01
# What eight cameras take of a face, from a plain surface to deep folds [s of one core], and of memory [bytes]
# (`camring bench meshes`).
LEAST_SECONDS, MOST_SECONDS, BYTES = 2e-5, 2e-4, 1500


@dataclass(frozen=True)
class Outlook:
    """What the ring sees, as parts of the whole, estimated at points.

    Attributes
    ----------
    in_view : float
        Area that is seen, from whichever side, over the area of the mesh.
    back : float
        How much of it is the back.
    away : int
        Parts of the mesh of which more back than front is seen, if they matter.
    inwards : int
        Parts that show the cameras their front and all around their back, if they are less than half of what is seen:
        of a solid in pieces one that is wound the wrong way does, and of a cavity in pieces each.
    """

    in_view: float
    back: float
    away: int
    inwards: int


def places(ring: exact.Ring) -> np.ndarray:
    """(8, 3) positions around the ring [mm]."""
    return ring.positions(ring.equidistant(PLACES))


def seen(mesh: trimesh.Trimesh, ring: exact.Ring) -> Outlook:
    """What a ring sees of a mesh.

    Examples
    --------
    >>> box = trimesh.creation.box((10, 10, 10))
    >>> found = seen(box, exact.Ring())
    >>> found.in_view > 1 / 6, found.back < 0.01, found.away
    (True, True, 0)
    """
    focus = np.array(ring.focus)
    cone = Cone(focus + ring.working_distance * ring.frame[:, 2], focus, 0.5 * float(np.hypot(*ring.fov)))
    vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces)
    body = bodies(faces).body
    found = facing(vertices, faces, body, places(ring), cone)
    turned = inwards(vertices, faces, body) if 1 < len(found.front) else np.zeros(1, dtype=bool)
    turned &= (found.front > PART_AWAY * found.front.sum()) & (found.front < 0.5 * found.front.sum())
    return Outlook(round(_in_view(found), 5), round(found.back_share, 5), _away(found), int(turned.sum()))


def forecast(n_faces: int) -> str:
    """What an evaluation takes, in words.

    Examples
    --------
    >>> forecast(4_000), forecast(1_000_000)
    ('under 1 s', '20 s to 3 min of one core and 1.5 GB')
    """
    least, most, memory = n_faces * LEAST_SECONDS, n_faces * MOST_SECONDS, n_faces * BYTES / 1e9
    if most < 1.0:
        return "under 1 s"
    return f"{_duration(least)} to {_duration(most)} of one core" + (f" and {memory:.1f} GB" if memory > 0.3 else "")


def _duration(seconds: float) -> str:
    return f"{seconds / 60:.0f} min" if seconds >= 90 else f"{max(seconds, 1.0):.0f} s"


def _in_view(found: Facing) -> float:
    return float((found.front + found.back).sum() / found.total.sum())


def _away(found: Facing) -> int:
    worth = found.back > PART_AWAY * (found.front + found.back).sum()
    return int((found.away & worth).sum())


def warnings_about(name: str, mesh: trimesh.Trimesh, ring: exact.Ring) -> list[str]:
    """What is odd about what a ring sees of a mesh, one sentence each, with what may be done."""
    found = seen(mesh, ring)
    said = []
    if found.back > BACK or found.away:
        parts = f", all that is seen of {found.away} of its parts" if found.away and found.back <= BACK else ""
        said.append(
            f"{name}: of the surface that faces the cameras {100 * found.back:.1f} % is its back{parts}, which counts "
            "nothing; --repair turns it if it is wound the wrong way, --two-sided counts both sides"
        )
    if found.inwards:
        said.append(
            f"{name}: {found.inwards} of its parts show the cameras their front, and all around their back, as the "
            "inside of a cavity does and a part of a solid that is wound the wrong way; camring check draws both"
        )
    if 0 < found.in_view < IN_VIEW:
        said.append(
            f"{name}: {100 * found.in_view:.1g} % of its surface is in view; if that is not meant, check its place "
            "(--focus and --axis, or --place auto, which finds them) and its unit (--scale)"
        )
    return said


def unit_words(extent: float, scale: float) -> str | None:
    """What the largest side [mm] says against millimetres, if anything."""
    likely = ", ".join(
        f"in {unit} it would be {extent * UNITS[unit]:.3g} mm (--scale {scale * UNITS[unit]:g})"
        for unit in other_units(extent)
    )
    hint = unit_hint(extent, scale)
    if likely and hint is None:
        return f"the largest side is {extent:.3g} mm; {likely}"
    return hint
