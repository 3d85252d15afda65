"""Wind the faces of a surface alike, and turn what looks away: by its volume if closed, else by who looks at it."""

import numpy as np

from meshes.condition.bodies import inside_out
from meshes.condition.facing import Cone, Facing, facing
from meshes.condition.neighbours import connected, neighbours
from meshes.errors import REPAIR_CALL, TWO_SIDED_CALL, MeshError


def halves(faces: np.ndarray, pairs: np.ndarray, alike: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The two halves of each body that are wound in opposite senses.

    Parameters
    ----------
    faces : (F, 3) int
    pairs, alike : (N, 2) int, (N,) bool
        As `neighbours` gives them.

    Returns
    -------
    body : (F,) int
        Number of the body of each face.
    half : (F,) bool
        True for faces that are wound unlike the first of their body.
    one_sided : (F,) bool
        Faces of bodies that cannot be wound alike.
    """
    # Two copies of every face, as it is and turned round; neighbours link the copies that agree. A surface that can
    # be wound alike falls apart into two mirrored halves; on a Moebius strip both copies of a face hang together.
    n = len(faces)
    a, b = pairs.T
    links = np.column_stack([np.r_[a, a + n], np.r_[np.where(alike, b, b + n), np.where(alike, b + n, b)]])
    _, label = connected(links, 2 * n)
    first, second = label[:n], label[n:]
    _, body = np.unique(np.minimum(first, second), return_inverse=True)
    return body, first > second, first == second


def wind_alike(
    name: str, vertices: np.ndarray, faces: np.ndarray, number: np.ndarray, notes: list[str], repairs: list[str],
    repair: bool, places: np.ndarray | None,
) -> np.ndarray:  # fmt: skip
    """Faces wound like their neighbours; where nobody sees it this changes no area, and needs no repair.

    Of the two halves of a body the one is turned that looks away from `places`, or, where nobody looks, the smaller.

    Raises
    ------
    MeshError
    """
    pairs, alike = neighbours(faces)
    if alike.all():
        return faces
    body, half, one_sided = halves(faces, pairs, alike)
    n_bodies = int(body.max()) + 1
    size, many = np.bincount(body, minlength=n_bodies), np.bincount(body, weights=half, minlength=n_bodies)
    turn_half = many <= size / 2  # else the other half
    unseen = False
    if places is not None:
        seen = facing(vertices, faces, 2 * body + half, places)
        front, back = (np.resize(np.append(one, [0, 0]), (n_bodies, 2)) for one in (seen.front, seen.back))
        turned_half, turned_rest = front[:, 0] + back[:, 1], front[:, 1] + back[:, 0]
        decided = turned_half != turned_rest
        turn_half[decided] = (turned_half > turned_rest)[decided]
        looked_at = (front + back)[np.arange(n_bodies), np.where(turn_half, 1, 0)]
        mixed = np.bincount(body[pairs[~alike, 0]], minlength=n_bodies) > 0
        unseen = not one_sided.any() and not looked_at[mixed].any()
    first = number[pairs[~alike][0]]
    if not (repair or unseen):
        raise MeshError(
            f"{name}: neighbouring faces {first[0]} and {first[1]} are wound in opposite senses, and so are "
            f"{int((~alike).sum()) - 1} more pairs; {REPAIR_CALL} winds them alike, or {TWO_SIDED_CALL} counts both "
            "sides"
        )
    if one_sided.any():
        raise MeshError(
            f"{name}: the surface through face {number[one_sided][0]} is one-sided, like a Moebius strip: a part of "
            f"it, such as a patch that fills a hole, is joined on crosswise. Cut it into two-sided parts, or count "
            f"both sides with {TWO_SIDED_CALL}"
        )
    turned = half == turn_half[body]
    turned &= (np.bincount(body[pairs[~alike, 0]], minlength=n_bodies) > 0)[body]
    told, why = (notes, ", which nobody sees") if unseen else (repairs, "")
    told.append(f"turned {_faces(int(turned.sum()))} round to wind all alike{why}")
    return np.where(turned[:, None], faces[:, ::-1], faces)


def turn_outside_out(
    name: str, vertices: np.ndarray, faces: np.ndarray, number: np.ndarray, notes: list[str], repairs: list[str],
    repair: bool, places: np.ndarray | None,
) -> np.ndarray:  # fmt: skip
    """Bodies turned that show their backs: closed ones by their volume, open ones if more back than front is seen.

    Raises
    ------
    MeshError
    """
    body, volume, inverted = inside_out(vertices, faces)
    closed_inverted = inverted.copy()
    if inverted.any() and not repair:
        worst = int(np.argmin(np.where(inverted, volume, np.inf)))
        raise MeshError(
            f"{name}: closed, but inside-out (its volume is {volume[worst]:.6g}), so that every face is seen from "
            f"behind; {REPAIR_CALL} turns it outside-out"
        )
    if repair and places is not None:
        pairs, _ = neighbours(faces)
        edges = np.bincount(pairs.ravel(), minlength=len(faces))
        is_open = np.bincount(body, weights=edges < 3, minlength=len(volume)) > 0
        away = facing(vertices, faces, body, places).away & is_open
        inverted = inverted | away
    if not inverted.any():
        return faces
    if count := int(closed_inverted.sum()):
        repairs.append(f"turned {count} {'body' if count == 1 else 'bodies'} outside-out")
    if count := int((inverted & ~closed_inverted).sum()):
        parts = f"{count} open {'part' if count == 1 else 'parts'}"
        faces_turned = int((inverted & ~closed_inverted)[body].sum())
        repairs.append(f"turned {parts} ({_faces(faces_turned)}) to face the cameras")
    return np.where(inverted[body][:, None], faces[:, ::-1], faces)


def both_sides(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F,) bool: faces whose back may be looked at: all but those of closed bodies wound outside-out."""
    pairs, alike = neighbours(faces)
    n_bodies, body = connected(pairs, len(faces))
    edges = np.bincount(pairs.ravel(), minlength=len(faces))
    fine = np.bincount(body, weights=edges < 3, minlength=n_bodies) == 0
    fine &= np.bincount(body[pairs[~alike, 0]], minlength=n_bodies) == 0
    corners = vertices[faces] - vertices[faces].mean(axis=(0, 1))
    cone = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    fine &= np.bincount(body, weights=cone, minlength=n_bodies) > 0
    return ~fine[body]


def outlook(vertices: np.ndarray, faces: np.ndarray, places: np.ndarray, view: Cone | None = None) -> Facing:
    """What is seen of each body of a surface (see `facing`)."""
    pairs, _ = neighbours(faces)
    _, body = connected(pairs, len(faces))
    return facing(vertices, faces, body, places, view)


def _faces(number: int) -> str:
    return f"{number} face{'' if number == 1 else 's'}"
