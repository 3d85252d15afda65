"""Bad input gets one clear answer: its exit status, one message, no traceback, nothing left behind."""

import re

import pytest

from tests.bad_input.cases import CASES


def everything(folder):
    """Files and links below a folder with their size and time. An empty folder that was made for results is none."""
    found = (path for path in folder.rglob("*") if path.is_symlink() or not path.is_dir())
    return {path: (path.lstat().st_size, path.lstat().st_mtime_ns) for path in found}


def test_there_are_many_cases():
    assert len(CASES) >= 60


@pytest.mark.parametrize("name", CASES)
def test_refused_with_one_message(camring, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    case = CASES[name]
    arguments = case.arguments(tmp_path)
    before = everything(tmp_path)
    status, out, err = camring(*arguments)
    assert (status, out) == (2, ""), err
    assert "Traceback" not in err
    said = [line for line in err.splitlines() if not line.startswith(("warning: ", "note: ", "repaired: "))]
    usage = said[0].startswith("Usage: ")  # an option that does not exist is answered with those that do
    assert usage or said[0].startswith("camring: ")
    assert usage or len(said) == 1
    assert re.search(case.message, " ".join(err.split())), err
    assert len(err) < 1500, "nobody reads that"
    assert everything(tmp_path) == before


@pytest.mark.parametrize("name", [name for name, case in CASES.items() if case.library])
def test_refused_by_the_library(tmp_path, name):
    case = CASES[name]
    case.arguments(tmp_path)
    with pytest.raises(case.error) as caught:
        case.library(tmp_path)
    assert re.search(case.message, " ".join(str(caught.value).split()))
