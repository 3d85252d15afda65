# `make demo` and `make test` do all the set-up themselves, in a fresh clone and again without reinstalling.
PYTHON ?= python3
BIN := .venv/bin

.PHONY: demo test lint clean

demo: .venv/installed
	$(BIN)/camring optimise circ_artery --depth 50 --cameras 4 --out out/demo --force

test: .venv/installed-test lint
	$(BIN)/pytest -n 2

lint: .venv/installed-test
	$(BIN)/ruff check .
	$(BIN)/pyright

.venv/bin/pip:
	$(PYTHON) -m venv .venv

.venv/installed: pyproject.toml | .venv/bin/pip
	$(BIN)/pip install --quiet --editable .
	touch $@

.venv/installed-test: pyproject.toml | .venv/bin/pip
	$(BIN)/pip install --quiet --editable '.[test]'
	touch .venv/installed $@

clean:
	rm -rf .venv out build *.egg-info
