# make demo and make test are the two commands of the README; both start from a machine with only Python 3.11.
PYTHON ?= python3
BIN := .venv/bin
export PYTHONPATH := $(CURDIR)

.PHONY: demo teach test test-all lint bench clean
.DELETE_ON_ERROR:

.venv/installed: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"
	$(BIN)/python -m pip install --quiet --editable ".[demo]" --group dev
	touch $@

demo: .venv/installed
	$(BIN)/subgoal demo --out out/demo

teach: .venv/installed
	$(BIN)/subgoal teach --out out/teach

lint: .venv/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

test: lint
	$(BIN)/pytest -m "not t2" -n 2 --dist worksteal

test-all: lint
	$(BIN)/pytest

bench: .venv/installed
	$(BIN)/python -m benchmarks

clean:
	rm -rf .venv out
