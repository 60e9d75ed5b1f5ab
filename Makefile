PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV   := .venv
BIN    := $(VENV)/bin

.PHONY: demo test check quality clean

demo: $(VENV)/ready            ## set up, splice the built-in motions, show the results, serve them
	$(BIN)/motionsplice demo demo

test: $(VENV)/ready            ## set up and run every test
	$(BIN)/python -m pytest -n auto --dist loadgroup

check: $(VENV)/ready           ## style, types and the arrows between the packages
	$(BIN)/ruff check . && $(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

$(VENV)/ready: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@

clean:
	rm -rf $(VENV) demo build dist
