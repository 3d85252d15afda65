"""Words of others, such as file names, as text in a figure."""

from functools import cache

from matplotlib.font_manager import FontProperties, findfont
from matplotlib.ft2font import FT2Font

MISSING = "□"


@cache
def _drawable() -> frozenset[int]:
    """Codes of all characters of the font that figures are set in."""
    return frozenset(FT2Font(findfont(FontProperties())).get_charmap())


def figure_text(words: str) -> str:
    r"""`words` for matplotlib: dollar signs begin no formula, and a box stands for what the font does not have.

    Examples
    --------
    >>> figure_text("3 $ to 4 $.stl"), figure_text("scan 術.stl")
    ('3 \\$ to 4 \\$.stl', 'scan □.stl')
    """
    known = "".join(one if one == "\n" or ord(one) in _drawable() else MISSING for one in words)
    return known.replace("$", r"\$")
