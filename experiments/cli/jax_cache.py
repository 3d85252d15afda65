"""Keep what JAX compiles between runs of the command line, so that the second run starts searching at once."""

import os
from collections.abc import MutableMapping

from platformdirs import user_cache_path

# Bytes of compiled functions to keep; one number of cameras takes about 1 MB.
MOST_KEPT = 500_000_000


def keep_compiled(environment: MutableMapping[str, str] = os.environ) -> None:
    """Tell JAX, which must not be imported yet, to keep compiled functions in the user's cache folder.

    Whoever has set JAX_COMPILATION_CACHE_DIR decides instead; empty means that nothing is kept.

    Examples
    --------
    >>> environment = {}
    >>> keep_compiled(environment)
    >>> environment["JAX_COMPILATION_CACHE_DIR"].endswith("jax")
    True
    """
    settings = {
        "JAX_COMPILATION_CACHE_DIR": str(user_cache_path("camring") / "jax"),
        "JAX_COMPILATION_CACHE_MAX_SIZE": str(MOST_KEPT),
        "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
        "JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES": "-1",
    }
    for name, value in settings.items():
        environment.setdefault(name, value)
