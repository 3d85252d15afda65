"""Load and check a mesh; build the reference sites."""

from meshes.check import check
from meshes.errors import MeshError
from meshes.load import load
from meshes.sites import DETAILS, SITES, Site, site
from meshes.top_surface import top_surface

__all__ = ["DETAILS", "SITES", "MeshError", "Site", "check", "load", "site", "top_surface"]
