# Everything a fresh clone needs: Python, make and a C library.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: demo test check lint types install clean

demo: $(VENV)/.demo-ready
	$(BIN)/lpslam demo --output demo

test: $(VENV)/.dev-ready
	$(BIN)/python -m pytest --numprocesses auto --maxprocesses 4 --dist worksteal

lint: $(VENV)/.dev-ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.dev-ready
	$(BIN)/mypy

check: lint types test

install: $(VENV)/.dev-ready

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.demo-ready: $(BIN)/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

$(VENV)/.dev-ready: $(BIN)/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable '.[dev,llm]'
	@touch $@

clean:
	rm -rf $(VENV) demo build dist
