"""What a command needs that comes with an extra of the installation."""

from importlib.util import find_spec

from experiments.files.errors import InputError

# Of each extra the modules, and the distributions that bring them.
EXTRAS = {
    "design": {"starlette": "starlette", "uvicorn": "uvicorn", "websockets": "websockets"},
    "simulate": {"mitsuba": "mitsuba", "cv2": "opencv-python-headless"},
}


def refuse_without(extra: str, command: str) -> None:
    """Refuse a command whose extra is not installed.

    Raises
    ------
    InputError

    Examples
    --------
    >>> refuse_without("design", "camring design")  # installed for the tests
    """
    missing = [name for module, name in EXTRAS[extra].items() if find_spec(module) is None]
    if missing:
        raise InputError(
            f"{command} needs {', '.join(missing)}, which {'is' if len(missing) == 1 else 'are'} not installed; "
            f"pip install 'camring[{extra}]'"
        )
