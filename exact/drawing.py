"""A reconstruction as it looks from somewhere: hidden parts removed exactly, each part with its number of views."""

from typing import TYPE_CHECKING

import numpy as np
import shapely

from exact.cameras import Camera
from exact.demand import Demand
from exact.predicted.reconstructed import divided
from exact.visibility.pieces.clipping import GRID_SIZE, whole_faces
from exact.visibility.projection import image_polygons
from exact.visibility.view import view_of

if TYPE_CHECKING:
    from exact.results import Reconstruction

NOT_COUNTED = -1


def seen_from(reconstruction: "Reconstruction", camera: Camera) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What `camera` shows of a reconstruction, cut where the number of views changes.

    Parameters
    ----------
    reconstruction : Reconstruction
    camera : Camera
        Any camera; it need not be one of those that reconstruct.

    Returns
    -------
    polygons : (N,) object
        Visible regions in the plane through the camera's target [mm right, mm down]; they do not overlap.
    n_views : (N,) int
        How many cameras see each, at most the reconstruction's threshold; `NOT_COUNTED` for excluded faces.
    face : (N,) int
        The face each is part of.

    Examples
    --------
    >>> import trimesh
    >>> from exact import Ring, evaluate
    >>> ring, plate = Ring(), trimesh.creation.box((10, 10, 2))
    >>> cameras = ring.cameras(ring.equidistant(2))
    >>> polygons, n_views, face = seen_from(evaluate(plate, cameras), Camera.look_at((0, 0, 400), (0, 0, 0), (0, 1, 0)))
    >>> n_views.tolist()
    [2, 2]
    """
    polygons, n_views, _, face = regions_from(reconstruction, camera, reconstruction.demand)
    return polygons, n_views, face


def regions_from(
    reconstruction: "Reconstruction", camera: Camera, demand: Demand
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """As `seen_from`, with (N,) bool before the last: whether each region meets `demand`, of no higher threshold."""
    scene = reconstruction.scene
    criterion = demand.of(reconstruction._cameras, scene.surface)
    tally, whole_met, piece_met = divided(scene.surface, scene.counted, reconstruction._tally, criterion)
    whole, cut_face, cut_piece = view_of(scene, camera)._parts
    shown_face, shown = np.concatenate([whole, cut_face]), np.concatenate([whole_faces(len(whole)), cut_piece])
    is_whole = np.arange(len(shown_face)) < len(whole)
    count = np.minimum(tally.whole_seen.sum(axis=1), reconstruction.threshold)
    count[~scene.counted] = NOT_COUNTED
    plain = ~tally.is_cut[shown_face]
    # Faces in pieces: each piece that meets what is shown of its face, clipped to it unless the face is shown whole.
    order = np.argsort(shown_face[~plain])
    among = shown_face[~plain][order]
    pieces = tally.pieces
    at = np.searchsorted(among, pieces.face)
    found = np.flatnonzero(
        (at < len(among)) & (among[np.minimum(at, len(among) - 1)] == pieces.face) if len(among) else []
    )
    index = np.flatnonzero(~plain)[order][at[found]]
    clipped = pieces.polygon[found].copy()
    partly = ~is_whole[index]
    clipped[partly] = shapely.intersection(clipped[partly], shown[index[partly]], grid_size=GRID_SIZE)
    piece_count = np.minimum(pieces.seen[found].sum(axis=1), reconstruction.threshold)
    face = np.concatenate([shown_face[plain], pieces.face[found]])
    polygon = np.concatenate([shown[plain], clipped])
    n_views = np.concatenate([count[shown_face[plain]], piece_count])
    met = np.concatenate([whole_met[shown_face[plain]], piece_met[found]])
    parts, owner = shapely.get_parts(polygon, return_index=True)
    areal = shapely.get_dimensions(parts) == 2  # an intersection may leave points and lines, which show nothing
    parts, owner = parts[areal], owner[areal]
    return image_polygons(scene.surface, camera, face[owner], parts), n_views[owner], met[owner], face[owner]
