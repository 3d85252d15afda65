"""What one layout is to serve: one mesh or several, each as it is or in several poses."""

from collections.abc import Sequence
from dataclasses import dataclass

import exact
import meshes
import placement
from experiments.files.errors import InputError
from experiments.files.ring_maximum_cache import RememberedAreas
from experiments.request.meshes import USUAL_FOV, Exclusion, Subject, exclusion, is_site, subject
from experiments.request.rig import Rig
from placement.layouts.arcs import LayoutSpace
from placement.layouts.constraints import demanded, on_ring


@dataclass(frozen=True, eq=False)
class Pose:
    """One mesh in one pose.

    Attributes
    ----------
    name : str
        Name of the mesh, with the number of the pose if there are several.
    scene : exact.Scene
        The mesh and what of it counts.
    weight : float
        How much it counts in the mean.
    """

    name: str
    scene: exact.Scene
    weight: float


@dataclass(frozen=True, eq=False)
class Request:
    """Meshes with the ring over them, all words understood.

    Attributes
    ----------
    subjects : (S,) tuple of Subject
    excluded : (S,) tuple of Exclusion
    weights : (S,) tuple of float
        How much each mesh counts in the mean.
    poses : (S J,) tuple of Pose
        J poses of the first mesh, then of the next; the first pose of each is the mesh as it is.
    ring : exact.Ring
    rig : Rig
    """

    subjects: tuple[Subject, ...]
    excluded: tuple[Exclusion, ...]
    weights: tuple[float, ...]
    poses: tuple[Pose, ...]
    ring: exact.Ring
    rig: Rig

    @property
    def n_poses(self) -> int:
        """Poses of each mesh."""
        return len(self.poses) // len(self.subjects)

    @property
    def name(self) -> str:
        """For headings."""
        n_more = len(self.subjects) - 1
        more = f" and {n_more} more" if n_more else ""
        return f"{self.subjects[0].name}{more}{f', {self.n_poses} poses' if self.n_poses > 1 else ''}"

    @property
    def of(self) -> str:
        """What a fraction is a fraction of, in words."""
        if len(self.poses) == 1:
            return "the ring maximum"
        kinds = ((len(self.subjects), "meshes"), (self.n_poses, "poses"))
        what = " and ".join(f"{number} {kind}" for number, kind in kinds if number > 1)
        return f"the ring maximum, {'the worst' if self.rig.objective == 'worst' else 'the mean'} of {what}"

    @property
    def demand(self) -> exact.Demand:
        """What makes a point count, with the baseline that the constraints ask for."""
        return on_ring(demanded(self.rig.demand, self.rig.constraints, self.ring), self.ring)

    @property
    def settings(self) -> placement.Settings:
        """Of the search, as they are for so many faces."""
        return self.rig.settings.for_faces(sum(pose.scene.n_faces for pose in self.poses))

    def check_cameras(self, n_cameras: int) -> None:
        """Refuse a number of cameras that cannot meet the constraints, before anything is computed.

        Raises
        ------
        placement.PlacementError
        """
        space = LayoutSpace(self.ring, n_cameras, self.rig.constraints)
        demanded(self.rig.demand, space.constraints, self.ring, space.n_cameras)

    def problem(self, progress, workers: int | None = None) -> placement.Problem:
        """The question to `placement`; `progress` is told what is being done. By default `workers` are all cores."""
        return placement.Problem(
            [pose.scene for pose in self.poses],
            self.ring,
            demand=self.rig.demand,
            settings=self.settings,
            seed=self.rig.seed,
            site_weights=[pose.weight for pose in self.poses],
            objective=self.rig.objective,  # type: ignore[arg-type] - checked by Problem
            progress=progress,
            workers=workers,
            memory=RememberedAreas(),
            ahead=True,
        )


def request(
    names: Sequence[str], depth: float | None, detail: str | None, rig: Rig, ring: exact.Ring | None = None
) -> Request:
    """What a command is about: these meshes or sites under the ring of `rig` (see `rig_file.rig`).

    `depth` is for sites that do not say theirs, as circ_flat@50 does. `ring` is one that goes before that of `rig`,
    such as that of a layout; the ring of what is given back stands in the place that was found, if one was looked for.

    Raises
    ------
    InputError, meshes.MeshError, exact.ExactError, placement.PlacementError

    Examples
    --------
    >>> from experiments.request.rig import rig
    >>> asked = request(["circ_flat@50", "circ_flat"], 100, "coarse", rig(jitter=2, site_weights="1,3"))
    >>> asked.subjects[1].name, asked.name, [pose.weight for pose in asked.poses]
    ('circ_flat, depth 100 mm', 'circ_flat, depth 50 mm and 1 more, 2 poses', [1.0, 1.0, 3.0, 3.0])
    """
    weights = (1.0,) * len(names) if rig.site_weights is None else rig.site_weights
    if len(weights) != len(names):
        raise InputError(f"site_weights are {weights}, and there are {len(names)} meshes; give one for each")
    if len(names) > 1 and rig.exclude not in (None, "top", "none"):
        raise InputError(
            f"--exclude is {rig.exclude!r}, face indices of one mesh, and there are {len(names)}; give top or none"
        )
    place = rig.place == "auto"
    if place and len(names) > 1:
        raise InputError(
            f"--place auto finds a place over one mesh, and there are {len(names)}; find it for one, as camring check "
            "does, and give its --focus and --axis for all"
        )
    likely_fov = meshes.SITES[names[0].partition("@")[0]].fov if place and is_site(names[0]) else USUAL_FOV
    subjects = _subjects(names, depth, detail, rig, rig.ring(likely_fov) if ring is None else ring, place)
    excluded = tuple(exclusion(about, rig.exclude) for about in subjects)
    fovs = dict.fromkeys(about.fov for about in subjects)
    if ring is None and rig.fov is None and len(fovs) > 1:
        wanted = " and ".join(f"{width:g}x{height:g}" for width, height in fovs)
        raise InputError(f"these meshes are meant for fields of view of {wanted} mm; say which with --fov")
    if place:
        ring = subjects[0].ring
    ring = rig.ring(subjects[0].fov) if ring is None else ring
    poses = []
    obstacles = tuple(subject(name, None, None, rig.repair, rig.scale).mesh for name in rig.obstacle or ())
    for about, left_out, weight in zip(subjects, excluded, weights, strict=True):
        turned = placement.jitter(about.mesh, rig.tilt_deg, rig.shift_mm, rig.jitter, rig.seed, ring.focus, ring.axis)
        for number, mesh in enumerate(turned, start=1):
            name = about.name if len(turned) == 1 else f"{about.name}, pose {number}"
            falling = None if rig.falloff_mm is None else placement.falloff(mesh, ring, rig.falloff_mm)
            poses.append(Pose(name, exact.Scene(mesh, left_out.mask, falling, obstacles, rig.light or ()), weight))
    return Request(subjects, excluded, weights, tuple(poses), ring, rig)


def _subjects(
    names: Sequence[str], depth: float | None, detail: str | None, rig: Rig, ring: exact.Ring, place: bool
) -> tuple[Subject, ...]:
    """Each mesh; of files and sites together, each with what belongs to its kind."""
    files = [name for name in names if not is_site(name)]
    undecided = [name for name in names if is_site(name) and "@" not in name]
    found = []
    for name in names:
        if name in files:
            kept = (depth, detail) if len(files) == len(names) else (None, None)
            found.append(subject(name, *kept, rig.repair, rig.scale, rig.two_sided, ring, place))
        else:
            own = None if "@" in name and undecided else depth
            scale = 1.0 if files else rig.scale
            found.append(subject(name, own, detail, rig.repair, scale, ring=ring, place=place))
    return tuple(found)
