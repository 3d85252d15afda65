# `make demo` and `make test` do all the set-up themselves, in a fresh clone and again without reinstalling.
PYTHON ?= python3
BIN := .venv/bin

.PHONY: demo test lint docs clean

demo: .venv/installed
	$(BIN)/camring optimise circ_artery --depth 50 --cameras 4 --out out/demo --force

# Needs Chromium or Chrome too, to look at reports with: on Debian and Ubuntu, apt-get install chromium.
test: .venv/installed-test lint
	$(BIN)/pytest -n 2

lint: .venv/installed-test
	$(BIN)/ruff check .
	$(BIN)/pyright

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

.venv/installed-docs: pyproject.toml | .venv/bin/pip
	$(BIN)/pip install --quiet --editable '.[docs]'
	touch .venv/installed $@

clean:
	rm -rf .venv out build *.egg-info
