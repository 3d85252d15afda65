"""What tests of the command line share."""

import pytest

from experiments.cli import main


@pytest.fixture
def camring(capsys):
    """Run the command; give its exit status, what it printed, and what it said on stderr."""

    def run(*arguments):
        with pytest.raises(SystemExit) as end:
            main([str(argument) for argument in arguments])
        printed = capsys.readouterr()
        return end.value.code or 0, printed.out, printed.err

    return run
