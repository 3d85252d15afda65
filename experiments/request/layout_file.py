"""The file `layout.json`: a ring and where its cameras sit, with the exact areas and all that repeats them."""

import difflib
import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import trimesh

import exact
from exact.requests import checked_demand, demand_keywords
from experiments.files.errors import InputError
from experiments.files.table import finite
from experiments.files.whole import written_whole
from experiments.request.declared_fields import declared
from experiments.request.meshes import is_site
from experiments.request.options import CLASSES, PARTS
from meshes import fingerprint

if TYPE_CHECKING:  # at run time it would bring jax along, which reading a layout hardly ever needs
    import placement
    from experiments.request.request import Request

FORMAT = "camring layout"
VERSION = 1
CONSTRAINTS = tuple(sorted(field.name for field in declared(*CLASSES["Constraints"])))
# What the file calls each field of a ring: with its unit, where it has one.
RING = {field.name: f"{field.name}_mm" if "[mm]" in field.words else field.name for field in declared(*CLASSES["Ring"])}
# All that any command has written into a layout file; another field is a slip of whoever edited it.
FIELDS = (
    "format", "version", "ring", "n_cameras", "threshold", "demand", "angles_deg", "angles_rad", "rolls_deg",
    "rolls_rad", "best_equidistant_phase_deg", "areas_mm2", "fractions_of_ring_maximum", "rms_errors_mm", "give_up",
    "most_area", "obstacles", "lights", "smallest_separation_mm", "mesh", "meshes", "objective", "poses", "falloff_mm",
    "constraints", "starts_rad", "certificate", "settings", "seed", "versions", "robustness", "mounting",
)  # fmt: skip
# Angles in degrees and in radians that differ by more than this [rad] were not meant to be the same.
SAME_ANGLE = 1e-6


@dataclass(frozen=True, eq=False)
class LayoutFile:
    """What is read back from a layout file; `demand` has the baseline of its constraints, `content` is all of it.

    `rolls` are those of the cameras (M,) [rad], as `exact.Ring.cameras` takes them; None if they are the ring's.
    """

    path: Path
    ring: exact.Ring
    angles: np.ndarray
    rolls: np.ndarray | None
    demand: exact.Demand
    content: dict[str, Any]

    @property
    def made_for(self) -> dict[str, str]:
        """Names of the meshes it was made for, as far as it says, by their fingerprints."""
        kept = [self.content.get("mesh"), *(self.content.get("meshes") or ())]
        return {mesh["sha256"]: mesh.get("name", "a mesh") for mesh in kept if mesh and mesh.get("sha256") is not None}

    def moved_to(self, ring: exact.Ring) -> exact.Demand:
        """What makes a point count once the ring stands elsewhere: depth that is along its axis stays so."""
        if self.demand.depth_axis != self.ring.axis:
            return self.demand
        return replace(self.demand, depth_axis=ring.axis)

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
        kept = self.content.get("mesh") or {}
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


def ring_content(ring: exact.Ring) -> dict[str, Any]:
    """The ring as it stands in the file, lengths in millimetres."""
    values = {key: getattr(ring, name) for name, key in RING.items()}
    return {key: list(value) if isinstance(value, tuple) else value for key, value in values.items()}


def placement_content(found: "placement.Placement", asked: "Request") -> dict[str, Any]:
    """A `placement.Placement` as it stands in the file.

    Areas are sums over the meshes, of several poses of a mesh their mean; fractions are what was maximised: the mean
    over all meshes and poses, or the worst. "mesh" is the first, "meshes" are all of them.
    """
    first, n_poses = found.sites[0], asked.n_poses
    names = ("optimised", "equidistant", "best_equidistant", "ring_maximum")
    areas = (found.area, found.equidistant_area, found.best_equidistant_area, found.ring_area)
    fractions = (found.fraction, found.equidistant_fraction, found.best_equidistant_fraction, 1.0)
    errors = {
        "optimised": found.error_rms,
        "equidistant": found.equidistant_error_rms,
        "best_equidistant": found.best_equidistant_error_rms,
        "most_area": found.most_area_error_rms,
    }
    return {
        "format": FORMAT,
        "version": VERSION,
        "ring": ring_content(found.ring),
        "n_cameras": found.n_cameras,
        "threshold": found.threshold,
        "demand": asdict(found.demand),
        "angles_deg": np.degrees(found.angles).tolist(),
        "angles_rad": list(found.angles),
        **rolls_content(found.rolls),
        "best_equidistant_phase_deg": float(np.degrees(found.best_equidistant_phase)),
        "areas_mm2": {name: area / n_poses for name, area in zip(names, areas, strict=True)},
        "fractions_of_ring_maximum": dict(zip(names, fractions, strict=True)),
        "rms_errors_mm": {name: finite(value) for name, value in errors.items()},
        "give_up": found.give_up,
        "most_area": {
            "angles_deg": np.degrees(found.most_area.angles).tolist(),
            "angles_rad": list(found.most_area.angles),
            **rolls_content(found.most_area.rolls),
            "area_mm2": found.most_area.area / n_poses,
            "fraction_of_ring_maximum": found.most_area.fraction,
        },
        **scene_content(asked),
        "smallest_separation_mm": found.smallest_separation if found.n_cameras > 1 else None,
        "mesh": {"name": asked.subjects[0].name, "sha256": first.mesh_hash, "excluded": asked.excluded[0].words,
                 "n_excluded_faces": first.n_excluded, **_loaded(asked, 0)},
        "meshes": [_mesh_content(found, asked, number) for number in range(len(asked.subjects))],
        "objective": found.objective,
        "constraints": asdict(found.constraints),
        "starts_rad": [list(start) for start in found.starts],
        "certificate": None if found.certificate is None else certificate_content(found.certificate),
        "settings": asdict(found.settings),
        "seed": found.seed,
        "versions": found.versions,
    }  # fmt: skip


def scene_content(asked: "Request") -> dict[str, Any]:
    """What stands around the meshes, and how each of them counts, as any layout file says it."""
    rig, scene = asked.rig, asked.poses[0].scene
    poses = {"n": asked.n_poses, "tilt_deg": rig.tilt_deg, "shift_mm": rig.shift_mm}
    return {
        "obstacles": [fingerprint(one) for one in scene.obstacles],
        "lights": [list(light) for light in scene.lights],
        "poses": poses if asked.n_poses > 1 else None,
        "falloff_mm": rig.falloff_mm,
    }


def rolls_content(rolls: tuple[float, ...] | None) -> dict[str, list[float]]:
    """Rolls of the cameras' own; nothing where they are the ring's."""
    return {} if rolls is None else {"rolls_deg": np.degrees(rolls).tolist(), "rolls_rad": list(rolls)}


def _mesh_content(found: "placement.Placement", asked: "Request", number: int) -> dict[str, Any]:
    """One mesh: what it is, how much it counts, and its areas in each pose."""
    sites = found.sites[number * asked.n_poses : (number + 1) * asked.n_poses]
    return {
        **mesh_content(asked, number, sites[0].mesh_hash),
        "areas_of_poses_mm2": [
            {"optimised": site.area, "equidistant": site.equidistant_area,
             "best_equidistant": site.best_equidistant_area, "ring_maximum": site.ring_area}
            for site in sites
        ],
    }  # fmt: skip


def mesh_content(asked: "Request", number: int, mesh_hash: str) -> dict[str, Any]:
    """One of the meshes asked for, as any layout file says it, with what it takes to load it again."""
    excluded = asked.excluded[number]
    return {
        "name": asked.subjects[number].name,
        "sha256": mesh_hash,
        "excluded": excluded.words,
        "n_excluded_faces": int(excluded.mask.sum()),
        **_loaded(asked, number),
        "weight": asked.weights[number],
    }


def _loaded(asked: "Request", number: int) -> dict[str, Any]:
    """How the mesh was loaded, so that it can be again, and what was said of it."""
    about, rig = asked.subjects[number], asked.rig
    if about.is_site:
        return {"scale": 1.0, "repair": False, "two_sided": False, **about.told}
    return {"scale": rig.scale, "repair": rig.repair, "two_sided": rig.two_sided, **about.told}


def certificate_content(certificate) -> dict[str, Any]:
    """A `placement.Certificate` as it stands in the file: fractions of the ring maximum of the samples."""
    return {
        "bound_fraction": certificate.bound_fraction,
        "gap": certificate.gap,
        "grid_bound_fraction": certificate.grid_bound_fraction,
        "grid_gap": certificate.grid_gap,
        "proven": certificate.proven,
        "surface": None if certificate.surface is None else asdict(certificate.surface),
        "statement": certificate.statement,
    }


def write(path: Path, content: dict[str, Any]) -> None:
    """Write `content` as JSON, whole or not at all."""
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")


def read(path: Path) -> LayoutFile:
    """Read and check a layout file.

    `angles_rad` is what counts; a file written by hand may give `angles_deg` instead.

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
    return understood(text, path)


def understood(text: str, path: Path) -> LayoutFile:
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
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise InputError(f'{path} is not a layout file: "format" must be "{FORMAT}"; camring optimise writes one')
    version = content.get("version")
    if version != VERSION or isinstance(version, bool):
        raise InputError(f"{path} has layout version {version!r}; only {VERSION} is known: update camring")
    try:
        _refuse_unknown(content, FIELDS, "")
        _check_meshes(content)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    ring = content.get("ring")
    if not isinstance(ring, dict) or not {"diameter_mm", "working_distance_mm", "fov_mm"} <= set(ring):
        raise InputError(f'{path}: "ring" must give diameter_mm, working_distance_mm and fov_mm')
    try:
        _refuse_unknown(ring, tuple(RING.values()), ' in "ring"')
        made = exact.Ring(**{name: ring[key] for name, key in RING.items() if key in ring})
        angles = _angles(content)
        rolls = _listed(content, "rolls", "rolls")
        made.cameras(angles, rolls)
        demand = _demand(content, made, len(angles))
    except (exact.ExactError, InputError) as error:
        raise InputError(f"{path}: {error}") from error
    return LayoutFile(path, made, angles, rolls, demand, content)


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
