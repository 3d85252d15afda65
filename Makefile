# `make demo` and `make test` do all the set-up themselves, in a fresh clone and again without reinstalling.
PYTHON ?= python3
BIN := .venv/bin
LOCK := UV_CUSTOM_COMPILE_COMMAND='make lock' $(BIN)/uv pip compile pyproject.toml --quiet --upgrade --python-version 3.11
PYTEST := $(BIN)/python -m slipcover --source meshes,exact,placement,experiments --skip-covered -m pytest -n 2
# A few minutes less than all: they touch every library that camring is made of.
OLDEST_TESTS := $(addprefix tests/,whole/test_dependencies.py exact/test_closed_forms.py \
	exact/rays/test_sites.py::test_awkward_meshes meshes/test_load.py placement/test_soft_coverage.py \
	bad_input/test_refused.py)

.PHONY: demo test test-all test-oldest compiled lint lock docs clean

demo: .venv/installed
	$(BIN)/camring optimise circ_artery --depth 50 --cameras 4 --out out/demo --force

# Needs Chromium or Chrome too, to look at reports with: on Debian and Ubuntu, apt-get install chromium. At the end it
# lists the lines that no test reaches in its own process.
test: .venv/installed-test lint compiled
	$(PYTEST)

# Those that take long, too: several times as long as `make test`.
test-all: .venv/installed-test lint compiled
	$(PYTEST) --all

# The oldest releases that pyproject.toml allows, in an environment of their own. What they warn of is of their time.
test-oldest: .venv-oldest/installed
	.venv-oldest/bin/pytest -n 2 -W default $(OLDEST_TESTS)

# Once for all processes that tests start, which write no bytecode.
compiled: .venv/installed-test
	$(BIN)/python -m compileall -q camring.py meshes exact placement experiments

lint: .venv/linted

.venv/linted: .venv/installed-test $(shell find *.py meshes exact placement experiments tests docs -name '*.py')
	$(BIN)/ruff check .
	$(BIN)/pyright
	touch $@

# Write both files of pinned releases anew: the newest and the oldest that pyproject.toml allows.
lock: .venv/bin/pip
	$(BIN)/pip install --quiet uv
	$(LOCK) --all-extras --universal --fork-strategy fewest --output-file requirements.lock
	$(LOCK) --extra cluster --resolution lowest-direct --output-file requirements-oldest.lock

# The documentation as web pages, out/docs/index.html; a warning is an error.
docs: .venv/installed-docs
	$(BIN)/sphinx-build -q -W --keep-going -d out/doctrees docs out/docs

.venv/bin/pip:
	$(PYTHON) -m venv .venv

.venv/installed: pyproject.toml | .venv/bin/pip
	$(BIN)/pip install --quiet --editable .
	touch $@

.venv/installed-test: pyproject.toml | .venv/bin/pip
	$(BIN)/pip install --quiet --editable '.[test]'
	touch .venv/installed $@

# Without camring, so that it may be made beside the other environment: both write what pip knows of it into one folder.
.venv-oldest/libraries: pyproject.toml requirements-oldest.lock
	$(PYTHON) -m venv .venv-oldest
	.venv-oldest/bin/pip install --quiet --requirement requirements-oldest.lock pytest pytest-xdist hypothesis beartype
	touch $@

.venv-oldest/installed: .venv-oldest/libraries
	.venv-oldest/bin/pip install --quiet --no-deps --editable .
	touch $@

.venv/installed-docs: pyproject.toml | .venv/bin/pip
	$(BIN)/pip install --quiet --editable '.[docs]'
	touch .venv/installed $@

clean:
	rm -rf .venv .venv-oldest out build *.egg-info
