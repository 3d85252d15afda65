"""Exact numbers of one layout after another, in a process of their own: what was seen before is not asked again."""

import json
import struct
from collections import OrderedDict
from collections.abc import Iterator
from functools import cache
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any

import numpy as np

import exact
from exact.show import TOO_NEAR_COLOUR, UNCOUNTED_COLOUR, colours, too_near
from experiments.design.design import MOST_CAMERAS, Design
from experiments.design.worker import Answer, Asked, latest, refusal
from experiments.report.scene import MISSED_COLOUR, MOST_SHADES, SEEN_COLOUR, hex_colour, views_words

if TYPE_CHECKING:
    import trimesh

# Layouts of all cameras but one whose views are kept: that of the hand, and those of the last ones it held.
MOST_KEPT = 6
# Colours of errors that are told apart.
N_RAMP = 32
# Bits beside those of the cameras, in what is told of each triangle.
RECONSTRUCTED, COUNTED = 1 << 30, 1 << 31
assert MOST_CAMERAS <= 30


class ExactAnswers:
    """Area, errors and what is seen of layouts over one scene.

    Parameters
    ----------
    scene : exact.Scene

    Examples
    --------
    >>> import placement, trimesh
    >>> answers = ExactAnswers(exact.Scene(trimesh.creation.box((10, 10, 1))))
    >>> design = Design.of(exact.Ring(), exact.Demand(), placement.Constraints(), [0.0, 3.0])
    >>> [kind for kind, _ in answers.of(design)]
    ['area', 'exact', 'surface', 'equidistant']
    """

    def __init__(self, scene: exact.Scene):
        self._scene = scene
        self._others: OrderedDict[tuple, exact.OneMoreView] = OrderedDict()
        self._even: dict[tuple, dict[str, float | None]] = {}

    def of(self, design: Design, moved: int | None = None) -> Iterator[tuple[str, Any]]:
        """What is known of a design, the first first: its area, its error, its surface, and the equidistant layout.

        The latter comes before the surface where it is known, and at the end in any case.

        `moved` is the camera that is likely to be moved next.
        """
        last = len(design.angles) - 1 if moved is None or moved >= len(design.angles) else moved
        seen = self._seen(design, last)
        area = seen.sets.area()
        yield "area", area
        order = np.array([*range(last), *range(last + 1, len(design.angles)), last])
        per_camera = (seen.sets.areas @ seen.sets.seen)[np.argsort(order)]
        yield "exact", {"area": area, "error": _error(seen, design), "cameras": per_camera.tolist()}
        if self._even_key(design) in self._even:
            yield "equidistant", self._equidistant(design)
        yield "surface", packed_surface(self._scene, seen.to_mesh(), design, order)
        yield "equidistant", self._equidistant(design)

    def _seen(self, design: Design, last: int):
        """What the cameras see, of which number `last` is the last one there."""
        others = tuple(angle for number, angle in enumerate(design.angles) if number != last)
        key = design.ring, design.whole, others
        if key not in self._others:
            cameras = design.ring.cameras(others) if others else ()
            self._others[key] = exact.OneMoreView(self._scene, cameras, demand=design.whole)
        self._others.move_to_end(key)
        while len(self._others) > MOST_KEPT:
            self._others.popitem(last=False)
        return self._others[key].seen(design.ring.cameras([design.angles[last]])[0])

    @staticmethod
    def _even_key(design: Design) -> tuple:
        return design.ring, design.whole, len(design.angles)

    def _equidistant(self, design: Design) -> dict[str, float | None]:
        key = self._even_key(design)
        if key not in self._even:
            cameras = design.ring.cameras(design.equidistant)
            seen = exact.OneMoreView(self._scene, cameras[:-1], demand=design.whole).seen(cameras[-1])
            self._even[key] = {"area": seen.sets.area(), "error": _error(seen, design)}
        return self._even[key]


def _error(seen: Any, design: Design) -> float | None:
    """Root mean square of the predicted errors [mm]; None where single cameras count, or nothing does."""
    if design.whole.threshold < 2:
        return None
    found = seen.errors.rms(design.whole.error)
    return found if np.isfinite(found) else None


def packed_surface(scene: exact.Scene, mesh: "trimesh.Trimesh", design: Design, order: np.ndarray) -> bytes:
    """The surface cut where the set of cameras changes, as `SeenWithOneMore.to_mesh` gives it, for the page.

    `order` (M,) is which camera of the design each of those of the mesh is.

    The length of the JSON that follows, as 4 bytes, little-endian like all of it; the JSON, with the numbers of
    vertices and triangles; vertices (V, 3) [mm] as float32; triangles (N, 3) as uint32; who sees each, (N,) uint32, a
    bit for each camera and those of `RECONSTRUCTED` and `COUNTED`; errors (N,) [mm] as float32, not finite where there
    is none.
    """
    demand, left_out = design.whole, np.flatnonzero(~scene.counted)
    bits = np.uint32(1) << order.astype(np.uint32)
    told = (mesh.face_attributes["seen"] * bits).sum(axis=1, dtype=np.uint32) | np.uint32(COUNTED)
    is_met = np.asarray(mesh.face_attributes["met"])
    told |= np.where(is_met, np.uint32(RECONSTRUCTED), np.uint32(0))
    error = np.where(is_met, mesh.face_attributes["error"], np.inf)
    faces = np.concatenate([mesh.faces, np.asarray(scene.everything.faces)[left_out] + len(mesh.vertices)])
    used, index = np.unique(faces, return_inverse=True)
    vertices = np.concatenate([mesh.vertices, scene.everything.vertices])[used]
    told = np.concatenate([told, np.zeros(len(left_out), dtype=np.uint32)])
    error = np.concatenate([error, np.full(len(left_out), np.inf)])
    palette, most = _palette(demand, len(order))
    head = {
        "shades": palette, "most": most, "ramp": _ramp(),
        "vertices": len(vertices), "triangles": len(faces), "threshold": demand.threshold, "of": demand.error,
        "focus": list(design.ring.focus), "frame": design.ring.frame.T.tolist(), "cameras": len(order),
    }  # fmt: skip
    text = json.dumps(head).encode()
    text += b" " * (-len(text) % 4)
    parts = (vertices.astype("<f4"), index.astype("<u4"), told.astype("<u4"), error.astype("<f4"))
    return struct.pack("<I", len(text)) + text + b"".join(part.tobytes() for part in parts)


def _palette(demand: exact.Demand, n_cameras: int) -> tuple[list[tuple[str, str]], int]:
    """Words and colour for each number of views, then for too near to each other, not counted, by a camera or not.

    Also from how many views on they are not told apart.
    """
    most = max(demand.threshold, min(n_cameras, MOST_SHADES))
    known = colours(most, demand.threshold)
    shades = [
        (views_words(count, most, n_cameras, demand), hex_colour(known[count])) for count in range(most + 1)
    ]  # fmt: skip
    shades += [(too_near(demand), TOO_NEAR_COLOUR), ("not counted", UNCOUNTED_COLOUR)]
    return [*shades, ("seen by this camera", SEEN_COLOUR), ("not seen by this camera", MISSED_COLOUR)], most


@cache
def _ramp() -> list[str]:
    """Colours from the least error to the greatest; their lightness falls, whatever colours an eye tells apart."""
    from matplotlib import colormaps

    return [hex_colour(colour[:3]) for colour in colormaps["viridis"](np.linspace(0.95, 0.0, N_RAMP))]


def answer(pipe: Connection, scene: exact.Scene) -> None:
    """Answer questions that come through a pipe until it is closed: always the latest, and no other to its end."""
    answers = ExactAnswers(scene)
    while True:
        asked: Asked = latest(pipe)
        try:
            for kind, found in answers.of(*asked.about):
                pipe.send(Answer(asked.number, kind, found))
                if pipe.poll():
                    break
        except Exception as error:
            pipe.send(Answer(asked.number, "refused", refusal(error)))
