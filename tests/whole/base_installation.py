"""Read mesh files as an installation without extras would: run with the folder that holds them, it prints as JSON.

Of the modules that are installed here, those that no library of the base installation brings cannot be imported.
"""

import json
import sys
from importlib.abc import MetaPathFinder
from importlib.metadata import packages_distributions, requires
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name


def base(name: str = "camring", extras: tuple[str, ...] = ("",), found: set[str] | None = None) -> set[str]:
    """Names of the distributions that an installation brings along, with these extras."""
    found = set() if found is None else found
    found.add(canonicalize_name(name))
    for line in requires(name) or ():
        needed = Requirement(line)
        wanted = needed.marker is None or any(needed.marker.evaluate({"extra": extra}) for extra in extras)
        if wanted and canonicalize_name(needed.name) not in found:
            base(needed.name, ("", *needed.extras), found)
    return found


class Refusal(MetaPathFinder):
    """Finds nothing of what the base installation does not have, and says so as Python does."""

    def __init__(self, allowed: set[str]):
        owners = packages_distributions()
        self.refused = {
            module for module, names in owners.items() if not allowed & {canonicalize_name(name) for name in names}
        }

    def find_spec(self, fullname, path=None, target=None):
        if fullname.partition(".")[0] in self.refused:
            raise ModuleNotFoundError(f"No module named {fullname!r}", name=fullname)


def main(folder: Path) -> None:
    """Load each file of the folder, and run what a new user runs first."""
    refusal = Refusal(base())
    for module in [module for module in sys.modules if module.partition(".")[0] in refusal.refused]:
        del sys.modules[module]  # packaging, which was needed to find out
    sys.meta_path.insert(0, refusal)
    import meshes

    found: dict[str, object] = {}
    for path in sorted(folder.iterdir()):
        try:
            found[path.name] = float(meshes.load(path).area)
        except meshes.MeshError as error:
            found[path.name] = str(error)
    from experiments.cli.app import main as camring

    statuses = []
    for arguments in json.loads(sys.argv[2]):
        try:
            camring(arguments)
        except SystemExit as end:
            statuses.append(end.code or 0)
    sys.stdout.write(json.dumps({"refused": sorted(refusal.refused), "found": found, "statuses": statuses}) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
