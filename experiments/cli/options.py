"""What subcommands of `camring` may be given: settings of a request, and what several of them share beside those.

Settings come from `experiments.request.options`, where their meaning is said; `asking` hands them to a subcommand.
Their own default is None, so that a rig file's value holds where an option is not given; the help shows what holds
without either.
"""

from collections.abc import Callable, Mapping
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Annotated, Any

import typer

from experiments.files.errors import InputError
from experiments.request.options import ON_THE_COMMAND_LINE, PARTS, Option, keys

# Names for the shell to complete; here once more, since where they come from imports what `--help` must not wait for.
SITES = (
    "circ_flat", "circ_angled", "circ_artery", "circ_overhang", "elliptical",
    "spine_disc", "cerebellopontine", "glioblastoma", "eye_anterior",
)  # fmt: skip
DETAILS = ("coarse", "middle", "fine")
BENCHMARKS = ("exact", "meshes", "sites", "surrogate")
FORMATS = ("colmap", "transforms", "opencv", "glb", "csv")


def completing(words: tuple[str, ...]):
    """Completion of an option's or argument's words; the shell offers files where none of them fits."""
    return lambda incomplete: [word for word in words if word.startswith(incomplete)]


MESH_HELP = "STL, OBJ, PLY or OFF file [mm], or the name of a built-in site"
Mesh = Annotated[str, typer.Argument(help=MESH_HELP, autocompletion=completing(SITES))]
Meshes = Annotated[
    list[str],
    typer.Argument(
        metavar="MESH...",
        help=f"{MESH_HELP}, with its depth if need be: circ_artery@100; several for one layout that serves all",
        autocompletion=completing(SITES),
    ),
]
Depth = Annotated[float | None, typer.Option(help="depth of a built-in site [mm]", show_default="the site's first")]
Detail = Annotated[
    str | None,
    typer.Option(help="size of a built-in site: coarse, middle or fine", autocompletion=completing(DETAILS)),
]
RigFile = Annotated[
    Path | None,
    typer.Option("--rig", help="TOML file of settings, as camring rig init writes one; options given here win over it"),
]
Target = Annotated[
    float | None,
    typer.Option(
        help="fraction of the ring maximum that must be reached, or the exit status is 1", show_default="none"
    ),
]
ReportOnly = Annotated[
    bool, typer.Option("--report-only", help="compute nothing; write tables and figures anew from what is there")
]
Scheduler = Annotated[
    str | None,
    typer.Option(help="address of a Dask scheduler, tcp://...", show_default="the processors of this machine"),
]
Json = Annotated[bool, typer.Option("--json", help="results as one JSON document on stdout")]
Out = Annotated[Path, typer.Option(help="folder for the results; it is made if need be")]
Force = Annotated[bool, typer.Option("--force", help="replace results that are already there")]

Given = dict[str, Any]
# Settings that several subcommands take, by the names of their keys, and of classes for all their fields.
RING_ITSELF = ("fov", "diameter", "working_distance", "focus", "axis", "zero_towards", "roll", "roll_deg")
RING = (*RING_ITSELF, "place")
MESH = ("exclude", "repair", "two_sided", "scale", "obstacle", "light")
REQUEST = (
    "Demand", "Constraints", *RING, "exclude", "objective", "site_weights", "falloff_mm", "jitter", "tilt_deg",
    "shift_mm", "seed", "certify", "certify_on", "repair", "two_sided", "scale", "obstacle", "light",
)  # fmt: skip


def refuse_ring_beside_layout(options: Given, rig_path: Path | None = None) -> None:
    """Refuse another ring than that of a layout.

    Raises
    ------
    InputError
    """
    if rig_path is not None or any(options[name] is not None for name in RING_ITSELF):
        flags = ["--rig", *(keys()[name].flag for name in RING_ITSELF)]
        raise InputError(
            f"a layout brings its own ring; leave {', '.join(flags[:-1])} and {flags[-1]} out; --place auto moves it "
            "over the mesh"
        )


class Asking:
    """A subcommand that takes settings of a request.

    It is called with everything by name, and calls `function` with the settings in one dict `options`, by the names of
    their keys. Which there are is looked up whenever its signature is read, for a class may have got another field.

    Parameters
    ----------
    function : callable
        With a parameter `options`, in whose place the settings stand.
    wanted : tuple of str
        Names of keys, and of classes for all their fields.
    otherwise : mapping
        What holds where an option is not given, in words, by the names of keys for which it is not the default.
    """

    def __init__(self, function: Callable[..., None], wanted: tuple[str, ...], otherwise: Mapping[str, str]):
        self.function, self.wanted, self.otherwise = function, wanted, otherwise
        self.__name__, self.__doc__ = function.__name__, function.__doc__
        self.__annotations__ = {}  # all of them stand in the signature

    @property
    def __signature__(self) -> Signature:
        asked = [_parameter(one, self.otherwise.get(one.name, one.shown_default)) for one in self._settings()]
        own = signature(self.function).parameters.values()
        everything = [two for one in own for two in (asked if one.name == "options" else [one])]
        return Signature([one.replace(kind=Parameter.KEYWORD_ONLY) for one in everything])

    def __call__(self, **given: Any) -> None:
        """Run it with what the command line gives."""
        options = {one.name: given.pop(_parameter_name(one)) for one in self._settings()}
        self.function(options=options, **given)

    def _settings(self) -> list[Option]:
        known, found = keys(*ON_THE_COMMAND_LINE), {}
        wanted = [part for name in self.wanted for part in (name, *PARTS.get(name, {}).values())]
        for name in wanted:
            found |= {one.name: one for one in known.values() if name in (one.name, *one.classes)}
        return list(found.values())


def asking(*wanted: str, otherwise: Mapping[str, str] | None = None) -> Callable[[Callable[..., None]], Asking]:
    """Let a subcommand take these settings of a request: names of keys, and of classes for all their fields.

    Examples
    --------
    >>> @asking("count", "repair")
    ... def show(options: Given, json: Json = False):
    ...     print(options["count"], options["repair"], json)
    >>> list(signature(show).parameters)
    ['cameras', 'repair', 'json']
    >>> show(cameras=3, repair=None, json=True)
    3 None True
    """
    return lambda function: Asking(function, wanted, otherwise or {})


def _parameter_name(option: Option) -> str:
    return option.option or option.name


def _parameter(option: Option, otherwise: str) -> Parameter:
    """The option as typer understands it."""
    no = (f"{option.flag}/--no-{option.flag[2:]}",) if option.kind.given_as is bool else ()
    completion = completing(option.choices) if option.choices else None
    shown = typer.Option(*no, help=option.help, show_default=otherwise, autocompletion=completion)
    return Parameter(
        _parameter_name(option),
        Parameter.KEYWORD_ONLY,
        default=None,
        annotation=Annotated[option.kind.given_as | None, shown],  # type: ignore[valid-type]
    )
