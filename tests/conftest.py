"""What tests of the command line share."""

import os
import sys
import tempfile

import matplotlib
import pytest
from jaxtyping import _import_hook, config

# SlipCover counts what is imported with its types checked only if it looks for modules before jaxtyping does.
for finder in [one for one in sys.meta_path if type(one).__name__ == "SlipcoverMetaPathFinder"]:
    sys.meta_path.remove(finder)
    sys.meta_path.insert(0, finder)
    _import_hook._JaxtypingLoader.get_code = lambda self, _: self.source_to_code(self.get_data(self.path), self.path)

from experiments.cli.app import main  # noqa: E402
from experiments.cli.jax_cache import keep_compiled  # noqa: E402
from tests.support import ROOT  # noqa: E402

# Processes that may not write much, as some tests start them, would leave modules behind that are cut off.
os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
# Compiling takes most of the time of many tests: the processes of a run share what they compile.
os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(ROOT / ".pytest_cache" / "jax"))
os.environ.setdefault("JAX_COMPILATION_CACHE_MAX_SIZE", "-1")  # a limit is a look at all of it for each function
keep_compiled()


LONG = ROOT / "tests" / "long.txt"


def pytest_addoption(parser):
    """`--all` runs the tests that take long, too."""
    parser.addoption("--all", action="store_true", help=f"run the tests that {LONG.name} lists, too")


def pytest_collection_modifyitems(config, items):
    """Leave out what takes long, unless all tests are to be run, or single ones are named."""
    named = {line for line in LONG.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")}
    if config.args == config.getini("testpaths") and (unknown := named - {item.nodeid for item in items}):
        raise pytest.UsageError(f"{LONG} names no tests: {', '.join(sorted(unknown))}; leave them out there")
    if config.getoption("--all"):
        return
    asked = tuple(argument for argument in config.args if "::" in argument)
    left_out = {name for name in named if not (asked and name.startswith(asked))}
    config.hook.pytest_deselected(items=[item for item in items if item.nodeid in left_out])
    items[:] = [item for item in items if item.nodeid not in left_out]


@pytest.fixture(scope="session", autouse=True)
def _own_cache_folder():
    """Nothing that earlier runs have remembered, and nothing for later ones."""
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        # Where matplotlib's list of fonts is: making it anew takes a while, and matplotlib says so.
        patch.setenv("MPLCONFIGDIR", matplotlib.get_cachedir())
        patch.setenv("XDG_CACHE_HOME", folder)
        yield


@pytest.hookimpl(tryfirst=True)  # before any fixture
def pytest_runtest_setup(item):
    """Check types where `placement` itself is tested: elsewhere the same once more would take a tenth of the time.

    Nor where Hypothesis draws: beartype takes Python's own random numbers, in threads too that an earlier test has
    left at work, and Hypothesis refuses to draw if they change meanwhile.
    """
    checked = item.nodeid.startswith(("placement/", "tests/placement/")) and not item.get_closest_marker("hypothesis")
    config.update("jaxtyping_disable", not checked)


@pytest.fixture
def unchecked():
    """No check of types before a function's own: for what is of a wrong type on purpose."""
    before = config.jaxtyping_disable
    config.update("jaxtyping_disable", True)
    yield
    config.update("jaxtyping_disable", before)


@pytest.fixture
def camring(capsys):
    """Run the command; give its exit status, what it printed, and what it said on stderr."""

    def run(*arguments):
        with pytest.raises(SystemExit) as end:
            main([str(argument) for argument in arguments])
        printed = capsys.readouterr()
        return end.value.code or 0, printed.out, printed.err

    return run


@pytest.fixture(scope="session")
def quick_search():
    """The part of a rig file that makes a search short, for what does not depend on how good it is."""
    return """
[search]
certify = false
n_samples = 300
n_angles = 24
n_starts = 3
n_start_phases = 1
n_phases = 4
exact_phases = 1
exact_candidates = 2
polish_steps = []
ring_cameras = 8
"""
