"""Too little memory: told before the start, where libraries would end the process without a word, and later."""

from collections.abc import Sequence

# What libraries reserve before anything is computed [bytes], measured with room to spare.
TO_SEARCH, TO_START = 2_500_000_000, 700_000_000
SEARCHING = ("optimise", "count", "tradeoff", "ring", "design", "simulate", "study", "bench")


def too_low(arguments: Sequence[str]) -> str | None:
    """Why a command cannot start under the address space that it is allowed (`ulimit -v`), or None if it can.

    Examples
    --------
    >>> too_low(["optimise", "circ_flat"]) is None  # no limit, or a high one
    True
    """
    try:
        import resource
    except ImportError:  # not on Windows, which has no such limit
        return None
    allowed, _ = resource.getrlimit(resource.RLIMIT_AS)
    command = next((word for word in arguments if not word.startswith("-")), "")
    needed = TO_SEARCH if command in SEARCHING else TO_START
    only_help = not command or {"-h", "--help"} & set(arguments)
    if only_help or allowed == resource.RLIM_INFINITY or allowed >= needed:
        return None
    return (
        f"not enough memory: {allowed / 1e9:.2g} GB of address space are allowed and `camring {command}` needs "
        f"{needed / 1e9:.2g} GB to start with; allow more (ulimit -v {needed // 1000})"
    )


def ran_out(error: BaseException) -> str:
    """What to say when memory ran out.

    Examples
    --------
    >>> ran_out(MemoryError())
    'not enough memory (none is left); take a coarser mesh, fewer cameras or fewer samples, or allow more (ulimit -v)'
    """
    what = str(error)[:120] or "none is left"
    return f"not enough memory ({what}); take a coarser mesh, fewer cameras or fewer samples, or allow more (ulimit -v)"
