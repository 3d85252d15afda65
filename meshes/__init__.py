"""Load and check a mesh; build the reference sites."""

from meshes.condition.check import check
from meshes.condition.inspection import Inspection, inspect
from meshes.errors import MeshError, MeshWarning
from meshes.file_faces import file_faces
from meshes.fingerprint import fingerprint
from meshes.formats.stl import stl_bytes
from meshes.load import load, read
from meshes.place import Place, place
from meshes.sites import DETAILS, SITES, Site, site
from meshes.standard import EXPECTED, Expected, standard_file
from meshes.top_surface import top_surface

__all__ = [
    "DETAILS",
    "EXPECTED",
    "SITES",
    "Expected",
    "Inspection",
    "MeshError",
    "MeshWarning",
    "Place",
    "Site",
    "check",
    "file_faces",
    "fingerprint",
    "inspect",
    "load",
    "place",
    "read",
    "site",
    "standard_file",
    "stl_bytes",
    "top_surface",
]
