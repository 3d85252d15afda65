import os
import subprocess
import sys

from experiments.cli.jax_cache import keep_compiled

ONE_FUNCTION = """
from experiments.cli.jax_cache import keep_compiled
keep_compiled()
import jax
jax.jit(lambda x: x * 2)(1.0)
"""


def test_compiled_functions_stay_in_the_cache_of_the_user(tmp_path):
    environment = {name: value for name, value in os.environ.items() if not name.startswith("JAX_")}
    environment |= {"XDG_CACHE_HOME": str(tmp_path), "HOME": str(tmp_path)}
    subprocess.run([sys.executable, "-c", ONE_FUNCTION], check=True, env=environment)
    kept = {path.name for path in tmp_path.rglob("*-cache")}
    assert kept
    subprocess.run([sys.executable, "-c", ONE_FUNCTION], check=True, env=environment)
    assert {path.name for path in tmp_path.rglob("*-cache")} == kept


def test_a_folder_of_ones_own_stays_as_it_is():
    environment = {"JAX_COMPILATION_CACHE_DIR": ""}
    keep_compiled(environment)
    assert environment["JAX_COMPILATION_CACHE_DIR"] == ""
