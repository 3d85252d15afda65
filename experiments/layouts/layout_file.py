"""A layout as it is read back from its file, `layout.json` of one ring or `several_rings.json`, and checked."""

import difflib
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import trimesh

import exact
from exact.requests import checked_demand, demand_keywords
from experiments.files.errors import InputError
from experiments.layouts.layout_content import FORMAT, RING, VERSION
from experiments.layouts.rings_content import MOST_CAMERAS, RINGS_FORMAT
from experiments.request.declared_fields import declared
from experiments.request.meshes import is_site
from experiments.request.options import CLASSES, PARTS
from experiments.request.placing import moved_with
from meshes import fingerprint

if TYPE_CHECKING:  # at run time it would bring jax along, which reading a layout hardly ever needs
    import placement

CONSTRAINTS = tuple(sorted(field.name for field in declared(*CLASSES["Constraints"])))
# All that any command has written into a layout file; another field is a slip of whoever edited it.
FIELDS = (
    "format", "version", "ring", "n_cameras", "threshold", "demand", "angles_deg", "angles_rad", "rolls_deg",
    "rolls_rad", "best_equidistant_phase_deg", "areas_mm2", "fractions_of_ring_maximum", "rms_errors_mm", "give_up",
    "most_area", "obstacles", "lights", "smallest_separation_mm", "mesh", "meshes", "objective", "poses", "falloff_mm",
    "constraints", "starts_rad", "certificate", "settings", "seed", "versions", "robustness", "mounting",
)  # fmt: skip
# The same of one on several rings.
FIELDS_OF_SEVERAL = (
    "format", "version", "rings", "n_cameras", "threshold", "demand", "cameras", "area_mm2", "fraction_of_all_rings",
    "rms_error_mm", "smallest_separation_mm", "all_rings_area_mm2", "most_area", "rings_alone", "give_up", "objective",
    "obstacles", "lights", "poses", "falloff_mm", "meshes", "constraints", "certificate", "settings", "seed",
    "versions",
)  # fmt: skip
# Angles in degrees and in radians that differ by more than this [rad] were not meant to be the same.
SAME_ANGLE = 1e-6


@dataclass(frozen=True, eq=False)
class LayoutFile:
    """What is read back from a layout file.

    Attributes
    ----------
    path : pathlib.Path
    rings : (K,) tuple of exact.Ring
    ring_of : (M,) ndarray of int
        Which of them each camera sits on, from 0.
    angles : (M,) ndarray
        Ring angles [rad].
    rolls : (M,) ndarray or None
        Of the cameras [rad], as `exact.Ring.cameras` takes them; None if they are those of their rings.
    demand : exact.Demand
        With the baseline of the constraints.
    content : dict
        All of it.
    """

    path: Path
    rings: tuple[exact.Ring, ...]
    ring_of: np.ndarray
    angles: np.ndarray
    rolls: np.ndarray | None
    demand: exact.Demand
    content: dict[str, Any]

    @property
    def ring(self) -> exact.Ring:
        """The ring, or the first of several."""
        return self.rings[0]

    @property
    def made_for(self) -> dict[str, str]:
        """Names of the meshes it was made for, as far as it says, by their fingerprints."""
        kept = [self.content.get("mesh"), *(self.content.get("meshes") or ())]
        return {mesh["sha256"]: mesh.get("name", "a mesh") for mesh in kept if mesh and mesh.get("sha256") is not None}

    def moved_to(self, ring: exact.Ring) -> exact.Demand:
        """What makes a point count once the ring stands elsewhere: depth that is along its axis stays so."""
        return moved_with(self.demand, self.ring, ring)

    def loaded(self, mesh: str, options: dict[str, Any]) -> dict[str, Any]:
        """How `mesh` is loaded as its own was, the first of several, with what options say otherwise.

        Returns
        -------
        dict
            `repair`, `two_sided`, and `scale`, which is 1 of a built-in site.

        Raises
        ------
        InputError
        """
        kept = self.content.get("mesh") or next(iter(self.content.get("meshes") or ()), {})
        found = {}
        for name in ("repair", "two_sided"):
            value = kept.get(name, False) if options.get(name) is None else options[name]
            if not isinstance(value, bool):
                raise InputError(f'{self.path}: "{name}" of its "mesh" is {value!r}; it must be true or false')
            found[name] = value
        scale = kept.get("scale", 1.0) if options.get("scale") is None else options["scale"]
        if isinstance(scale, bool) or not isinstance(scale, int | float) or not scale > 0:
            raise InputError(f'{self.path}: the "scale" of its "mesh" is {scale!r}; it must be a positive number')
        return found | {"scale": 1.0 if is_site(mesh) else float(scale)}

    def refuse_other_mesh(self, mesh: trimesh.Trimesh, name: str, force: bool | None) -> None:
        """Refuse a mesh that it was not made for, unless it does not say for which, or with `force`.

        `force` is None where there is no such option to offer.

        Raises
        ------
        InputError
        """
        if force or not self.made_for or fingerprint(mesh) in self.made_for:
            return
        meant = " or ".join(repr(known) for known in dict.fromkeys(self.made_for.values()))
        otherwise = "leave the layout out" if force is None else "--force to use the layout with this one"
        raise InputError(
            f"{self.path} was made for {meant}, and {name} is not the same mesh; give that one, or {otherwise}"
        )


def read(path: Path, several: bool = False) -> LayoutFile:
    """Read and check a layout file.

    `angles_rad` is what counts; a file written by hand may give `angles_deg` instead.

    Parameters
    ----------
    path : pathlib.Path
    several : bool
        Whether it may be of several rings.

    Raises
    ------
    InputError
        If it is not there, not JSON, or says too little or something else than a layout.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot read layout {path}: {error.strerror}") from error
    except ValueError as error:
        raise InputError(f"{path} is not a layout file: it holds no valid JSON ({error})") from error
    return understood(text, path, several)


def understood(text: str, path: Path, several: bool = False) -> LayoutFile:
    """The layout that the text of a file gives; `path` is what messages call it.

    Raises
    ------
    InputError
        As by `read`.
    """
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is not a layout file: it holds no valid JSON ({error})") from error
    kind = content.get("format") if isinstance(content, dict) else None
    if kind == RINGS_FORMAT and not several:
        raise InputError(f"{path} is a layout on several rings; camring evaluate and export take one, this does not")
    if kind not in (FORMAT, RINGS_FORMAT):
        raise InputError(f'{path} is not a layout file: "format" must be "{FORMAT}"; camring optimise writes one')
    version = content.get("version")
    if version != VERSION or isinstance(version, bool):
        raise InputError(f"{path} has layout version {version!r}; only {VERSION} is known: update camring")
    try:
        _refuse_unknown(content, FIELDS_OF_SEVERAL if kind == RINGS_FORMAT else FIELDS, "")
        _check_meshes(content)
        if kind == RINGS_FORMAT:
            rings, ring_of, angles = _on_rings(content)
            rolls = None
        else:
            rings, angles = (_ring(content.get("ring"), '"ring"', ()),), _angles(content)
            rolls = _listed(content, "rolls", "rolls")
            ring_of = np.zeros(len(angles), dtype=int)
            rings[0].cameras(angles, rolls)
        demand = _demand(content, rings[0], len(angles))
    except (exact.ExactError, InputError) as error:
        raise InputError(f"{path}: {error}") from error
    return LayoutFile(path, rings, ring_of, angles, rolls, demand, content)


def _ring(given: Any, where: str, more: tuple[str, ...]) -> exact.Ring:
    """A ring; it may have fields of other names `more`."""
    if not isinstance(given, dict) or not {"diameter_mm", "working_distance_mm", "fov_mm"} <= set(given):
        raise InputError(f"{where} must give diameter_mm, working_distance_mm and fov_mm")
    _refuse_unknown(given, (*RING.values(), *more), f" in {where}")
    return exact.Ring(**{name: given[key] for name, key in RING.items() if key in given})


def _on_rings(content: dict[str, Any]) -> tuple[tuple[exact.Ring, ...], np.ndarray, np.ndarray]:
    """The rings, which of them each camera sits on, from 0, and ring angles [rad]."""
    given, cameras = content.get("rings"), content.get("cameras")
    if not isinstance(given, list) or not given:
        raise InputError('"rings" must list at least one ring')
    rings = tuple(_ring(one, f"ring {k} of " + '"rings"', (MOST_CAMERAS,)) for k, one in enumerate(given, start=1))
    if not isinstance(cameras, list) or not cameras:
        raise InputError('"cameras" must list at least one camera')
    ring_of, angles = [], []
    for number, camera in enumerate(cameras, start=1):
        k = camera.get("ring") if isinstance(camera, dict) else None
        if isinstance(k, bool) or not isinstance(k, int) or not 1 <= k <= len(rings):
            raise InputError(
                f'camera {number} of "cameras" must give its "ring", a whole number from 1 to {len(rings)}'
            )
        one = {f"angles_{unit}": [camera[key]] for unit in ("rad", "deg") if (key := f"ring_angle_{unit}") in camera}
        found = _listed(one, "angles", f"ring angle of camera {number}")
        if found is None:
            raise InputError(f'camera {number} of "cameras" must give "ring_angle_rad" or "ring_angle_deg"')
        ring_of.append(k - 1)
        angles.append(float(found[0]))
    if content.get("n_cameras", len(angles)) != len(angles):
        raise InputError(f'"n_cameras" is {content["n_cameras"]!r}, and there are {len(angles)} cameras')
    return rings, np.array(ring_of), np.array(angles)


def _demand(content: dict[str, Any], ring: exact.Ring, n_cameras: int) -> exact.Demand:
    """What makes a point count: of baselines in "demand" and "constraints" the greater; a file need give neither."""
    threshold = content.get("threshold", 2)
    if isinstance(threshold, bool) or not isinstance(threshold, int) or not 1 <= threshold <= n_cameras:
        raise InputError(f'"threshold" is {threshold!r}; it must be a whole number from 1 to {n_cameras}')
    given = content.get("demand", {})
    known = tuple(demand_keywords())
    if not isinstance(given, dict) or not set(given) <= set(known):
        raise InputError(f'"demand" is {str(given)[:80]}; it must give some of {", ".join(known)}')
    if "threshold" in content and given.get("threshold", threshold) != threshold:
        raise InputError(f'"threshold" is {threshold} and in "demand" {given["threshold"]!r}; leave one of them out')
    parts = {name: _part(kind, given[name]) for name, kind in PARTS["Demand"].items() if name in given}
    demand = checked_demand({"threshold": threshold} | given | parts)
    demand.refuse_fewer(n_cameras)
    # A file written by hand need not say along what depth is measured: on a ring, along its axis.
    axis = demand.depth_axis or ring.axis
    return replace(demand, min_baseline=max(demand.min_baseline, _baseline(content, ring)), depth_axis=axis)


def _part(kind: str, given: Any) -> Any:
    """The limits or optics of a demand."""
    known = tuple(field.name for field in declared(*CLASSES[kind]))
    if not isinstance(given, dict) or not set(given) <= set(known):
        raise InputError(f'"{kind.lower()}" is {str(given)[:80]}; it must give some of {", ".join(known)}')
    return getattr(exact, kind)(**given)


def _baseline(content: dict[str, Any], ring: exact.Ring) -> float:
    """Baseline of the constraints [mm]; 0 for a file that says nothing of them, such as one written by hand."""
    kept = content.get("constraints", {})
    if not isinstance(kept, dict) or not set(kept) <= set(CONSTRAINTS):
        raise InputError(f'"constraints" is {kept!r}; it must give some of {", ".join(CONSTRAINTS)}')
    asked = {name: kept[name] for name in ("min_baseline", "min_angle") if kept.get(name, 0) != 0}
    if not asked:
        return 0.0
    import placement

    try:
        return placement.Constraints(**asked).baseline(ring)
    except placement.PlacementError as error:
        raise InputError(str(error)) from error


def constraints_of(kept: dict[str, Any]) -> "placement.Constraints":
    """Constraints as `camring optimise` writes them."""
    import placement

    arcs = tuple((start, end) for start, end in kept["forbidden"])
    return placement.Constraints(**(kept | {"fixed": tuple(kept["fixed"]), "forbidden": arcs}))


def _angles(content: dict[str, Any]) -> np.ndarray:
    given = _listed(content, "angles", "ring angles")
    if given is None:
        raise InputError('it gives no ring angles; "angles_rad" or "angles_deg" must list them')
    if content.get("n_cameras", len(given)) != len(given):
        raise InputError(f'"n_cameras" is {content["n_cameras"]!r}, and there are {len(given)} ring angles')
    return given


def _listed(content: dict[str, Any], name: str, words: str) -> np.ndarray | None:
    """Angles that are listed in radians, in degrees, or in both; None if in neither."""
    given = []
    for key, unit in ((f"{name}_rad", 1.0), (f"{name}_deg", np.pi / 180)):
        if key not in content:
            continue
        values = content[key]
        numbers = isinstance(values, list) and values
        if not numbers or any(isinstance(v, bool) or not isinstance(v, int | float) for v in values):
            raise InputError(f'"{key}" must be a list of at least one number')
        try:
            given.append(np.array(values, dtype=np.float64) * unit)
        except OverflowError as error:  # whole numbers of hundreds of digits
            raise InputError(f'the {words} of "{key}" must all be finite') from error
    if not given:
        return None
    if not np.isfinite(given[0]).all():
        raise InputError(f"{words} {given[0].tolist()} are not all finite [rad]")
    # Whoever edits one of the two by hand must not get the areas of the other.
    if len(given[0]) != len(given[-1]) or not (np.abs(given[0] - given[-1]) <= SAME_ANGLE).all():
        raise InputError(f'"{name}_deg" and "{name}_rad" are not the same angles; leave one of them out')
    return given[0]


def _refuse_unknown(kept: dict[str, Any], known: tuple[str, ...], where: str) -> None:
    for name in kept:
        if name not in known:
            near = difflib.get_close_matches(name.lower(), known, n=1)
            meant = f"; did you mean {near[0]}?" if near else ","
            raise InputError(f"there is no field {name[:40]!r}{where}{meant} fields are {', '.join(known)}")


def _check_meshes(content: dict[str, Any]) -> None:
    """What is said of meshes must be what is read of it."""
    several = content.get("meshes")
    if not (several is None or isinstance(several, list)):
        raise InputError(f'"meshes" is {several!r}; it must be a list of what "mesh" gives')
    for mesh in (content.get("mesh"), *(several or ())):
        words = mesh is None or (
            isinstance(mesh, dict) and all(isinstance(mesh.get(key, ""), str) for key in ("name", "sha256"))
        )
        if not words:
            raise InputError(f'"mesh" is {str(mesh)[:80]}; it must give "name" and "sha256", both in quotes')
