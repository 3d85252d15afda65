"""Bad input of every kind, and what the command line says to it.

Each case is a function of an empty folder, which it fills, and gives the arguments of `camring`; with the words that
the one message on stderr must hold, and, where a library call reads the same input, that call and its exception.
"""

from tests.bad_input.cases.layout_files import LAYOUTS
from tests.bad_input.cases.mesh_files import MESHES, SCENES
from tests.bad_input.cases.requests import COMMANDS, EXCLUDED, OPTIONS, OUTPUTS, RIGS

CASES = MESHES | SCENES | LAYOUTS | RIGS | OPTIONS | COMMANDS | EXCLUDED | OUTPUTS
