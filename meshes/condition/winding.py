"""Wind the faces of a surface alike, and turn what looks away: by its volume if closed, else by who looks at it."""

import numpy as np

from meshes.condition.bodies import inside_out
from meshes.condition.facing import facing, sides
from meshes.condition.neighbours import bodies, connected, neighbours
from meshes.errors import REPAIR_CALL, TWO_SIDED_CALL, MeshError

# Places all around, and how far away, in sizes of the mesh; and how many times more of one side than of the other is
# seen from there of what has an outside: of a flat sheet as much of both, of a half sphere twice as much.
AROUND, DISTANCE, CLEARLY = 48, 10.0, 1.5
# Enough points to tell which way a body is turned.
FEW_POINTS = 2_000


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
    """Faces wound like their neighbours: of the two halves of a body that are wound unlike, the smaller is turned.

    Where one of them is not seen from `places`, that one is, which changes no area and needs no repair.

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
    mixed = np.bincount(body[pairs[~alike, 0]], minlength=n_bodies) > 0
    if places is not None and not (repair or one_sided.any()):
        seen = facing(vertices, faces, 2 * body + half, places)
        looked_at = np.zeros(2 * n_bodies, dtype=bool)
        looked_at[: len(seen.front)] = seen.front + seen.back > 0
        looked_at = looked_at.reshape(n_bodies, 2)
        turn_half = np.where(looked_at[:, 0] == looked_at[:, 1], turn_half, looked_at[:, 0])
        unseen = not looked_at[mixed].all(axis=1).any()
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
    turned &= mixed[body]
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
        away = facing(vertices, faces, body, places).away & ~bodies(faces).closed
        if away.any():
            _refuse_to_guess(name, vertices, faces, number, body, away)
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


def _refuse_to_guess(name, vertices, faces, number, body, away) -> None:
    """Refuse a surface that shows its back to the cameras and clearly its front to all the world around."""
    around = facing(vertices, faces, body, sphere_around(vertices[faces].reshape(-1, 3)))
    doubtful = away & (around.front > CLEARLY * around.back)
    if doubtful.any():
        own = number[doubtful[body]]
        raise MeshError(
            f"{name}: the open surface through face {own[0]} ({_faces(len(own))}) shows its back to the cameras, and "
            "its front to all around: a cavity wound the wrong way, or a shell of which a part is missing. "
            f"{TWO_SIDED_CALL} counts both sides"
        )


def sphere_around(points: np.ndarray, number: int = AROUND) -> np.ndarray:
    """Places evenly all around points (N, 3), far away: (`number`, 3)."""
    low, high = points.min(axis=0), points.max(axis=0)
    k = np.arange(number) + 0.5  # a spiral from pole to pole (Fibonacci)
    height, turn = 1 - 2 * k / number, k * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - height**2)
    directions = np.column_stack([across * np.cos(turn), across * np.sin(turn), height])
    return 0.5 * (low + high) + DISTANCE * np.linalg.norm(high - low) * directions


def both_sides(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F,) bool: faces whose back may be looked at: all but those of closed bodies wound outside-out."""
    pairs, alike, body, closed = bodies(faces)
    fine = closed & (np.bincount(body[pairs[~alike, 0]], minlength=len(closed)) == 0)
    corners = vertices[faces] - vertices[faces].mean(axis=(0, 1))
    cone = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    fine &= np.bincount(body, weights=cone, minlength=len(closed)) > 0
    return ~fine[body]


def inwards(vertices: np.ndarray, faces: np.ndarray, body: np.ndarray) -> np.ndarray:
    """(B,) bool: bodies (numbered by `body`, (F,)) that show clearly more of their back than of their front all around.

    A cavity does so, and a part of a solid that is wound the wrong way.
    """
    front, back, _ = sides(vertices, faces, body, sphere_around(vertices[faces].reshape(-1, 3)), n_points=FEW_POINTS)
    return back.sum(axis=0) > CLEARLY * front.sum(axis=0)


def _faces(number: int) -> str:
    return f"{number} face{'' if number == 1 else 's'}"
