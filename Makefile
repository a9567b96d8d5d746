# Everything a fresh clone needs: Python, make and a C library.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

# Modules are compiled when they are first imported, and then kept: by installing, all of them would be, in twice the time.
export PYTHONDONTWRITEBYTECODE :=
# Workers share the processors best with one thread each, as the commands do.
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
PIP_INSTALL := python -m pip install --quiet --no-compile
# uv chooses versions and unpacks in ten seconds, pip in sixty; where uv cannot be had or fails, pip does it.
UV_INSTALL := uv pip install --quiet --python $(BIN)/python

.PHONY: demo test check lint types install versions clean

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

# The quick tests under every other Python that is installed; `make test` has run all of them under the first.
versions: $(VENV)/.dev-ready
	@for version in 3.11 3.12 3.13; do \
	  python$$version -c "" 2> /dev/null || { echo "python$$version is not installed: skipped"; continue; }; \
	  $(BIN)/python --version | grep -q " $$version\." && continue; \
	  python$$version -m venv .venvs/$$version && \
	  { .venvs/$$version/bin/$(PIP_INSTALL) --upgrade pip || true; } && \
	  .venvs/$$version/bin/$(PIP_INSTALL) --editable '.[dev,llm]' && \
	  .venvs/$$version/bin/python -m pytest -q -m "not slow" --numprocesses auto --maxprocesses 4 || exit 1; \
	done

install: $(VENV)/.dev-ready

# An older pip takes three times as long to choose versions; without either of the two it installs all the same.
$(BIN)/python:
	$(PYTHON) -m venv $(VENV)
	-$(BIN)/$(PIP_INSTALL) --only-binary :all: --upgrade pip uv

$(VENV)/.demo-ready: $(BIN)/python pyproject.toml
	$(BIN)/$(UV_INSTALL) --editable . || $(BIN)/$(PIP_INSTALL) --editable .
	@touch $@

$(VENV)/.dev-ready: $(BIN)/python pyproject.toml
	$(BIN)/$(UV_INSTALL) --editable '.[dev,llm]' || $(BIN)/$(PIP_INSTALL) --editable '.[dev,llm]'
	@touch $@

clean:
	rm -rf $(VENV) .venvs demo build dist
