"""camring under one name: `import camring`, and `python -m camring` for the command line.

The packages keep their own names, `meshes`, `exact` and `placement`, and are imported when they are first used.

Examples
--------
>>> import camring
>>> ring = camring.Ring()  # the same as exact.Ring
>>> plate = camring.site("circ_artery", depth=50)  # the same as meshes.site
>>> camring.evaluate is camring.exact.evaluate
True
"""

from importlib import import_module
from importlib.metadata import version as _version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import exact as exact
    import meshes as meshes
    import placement as placement

_PACKAGES = ("meshes", "exact", "placement")  # the lightest first


def __getattr__(name: str) -> Any:
    if name in _PACKAGES:
        return import_module(name)
    if name == "__version__":
        return _version("camring")
    if not name.startswith("_"):
        for package in map(import_module, _PACKAGES):
            if name in package.__all__:
                return getattr(package, name)
    raise AttributeError(f"camring has no {name!r}; its packages are {', '.join(_PACKAGES)}")


def __dir__() -> list[str]:
    public = [name for package in map(import_module, _PACKAGES) for name in package.__all__]
    return sorted({*_PACKAGES, "__version__", *public})


if __name__ == "__main__":
    from experiments.cli.app import main

    main()
