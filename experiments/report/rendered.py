"""What every report shows alike: the request, the surface in three dimensions, and how to repeat it."""

from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from plotly.offline import get_plotlyjs

from experiments.report import request_text
from experiments.report.scene import DrawnSurface, packed


def rendered(template: str, made: request_text.Made, drawn: DrawnSurface, **own: Any) -> str:
    """A page as HTML; whatever comes from files is shown as text.

    Parameters
    ----------
    template : str
        Name of a template; `own` is what it takes besides what all take.
    made : Made
    drawn : DrawnSurface
        The first of the meshes.
    """
    content = made.content
    # Everything that is put into the page is escaped; what is packed is base64, which has nothing to escape.
    environment = Environment(
        loader=PackageLoader("experiments.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    return environment.get_template(template).render(
        name=", ".join(about["name"] for about in content["meshes"]),
        shown=content["meshes"][0]["name"],
        is_single=len(content["meshes"]) == 1 and content["poses"] is None,
        n_cameras=content["n_cameras"],
        asked=request_text.asked(made),
        scene=drawn.content(),
        surface=drawn.packed(),
        plotly=packed(get_plotlyjs().encode("utf-8")),
        rig=request_text.rig(made),
        command=request_text.command(made),
        evaluation=request_text.evaluation(made),
        seed=content["seed"],
        hashes=[(about["name"], about["sha256"]) for about in content["meshes"]],
        versions=content["versions"],
        **own,
    )
