"""A rig file to start from: every key with its default, below what it means."""

import json
import textwrap
from typing import Any

from experiments.request.options import sections

HEAD = """
Rig file of camring: ring, cameras, constraints and search of a request, for --rig.
Lengths are in millimetres. Angles are in degrees where a key ends in _deg, else in radians, as its comment says.
Every key has its default here, and may be left out. An option on the command line wins over this file.
"""


def commented() -> str:
    """The text of a rig file that holds every key with its default, each below what it means.

    Examples
    --------
    >>> commented().splitlines()[4:7]
    ['[ring]', '# Diameter of the ring [mm].', 'diameter = 30.0']
    """
    lines = [f"# {line}" for line in HEAD.strip().splitlines()]
    for section, keys in sections().items():
        lines += ["", f"[{section}]"]
        for name, key in keys.items():
            # Without a default there is nothing to set: an example takes its place, commented out.
            unset = key.default is None
            words = f"{key.meaning} Unless given: {key.shown_default}." if unset else key.meaning
            lines += [f"# {line}" for line in textwrap.wrap(words, 110)]
            lines.append(f"# {name} = {key.kind.example}" if unset else f"{name} = {toml_value(key.default)}")
    return "\n".join(lines) + "\n"


def toml_value(value: Any) -> str:
    """A number, text, truth value or (nested) tuple of them as TOML, which writes these as JSON does.

    Examples
    --------
    >>> toml_value(((60.0, 90.0),)), toml_value(True), toml_value("top")
    ('[[60.0, 90.0]]', 'true', '"top"')
    """
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
