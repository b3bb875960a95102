# Everything is made with Python >= 3.11 and what PyPI offers; `make help` lists the targets.

PYTHON ?= python3
VENV := .venv
BUILD := build
BIN := $(VENV)/bin
IMAGE ?=
ARGS ?=

CORE := $(VENV)/.installed-core
TEST := $(VENV)/.installed-test
EVAL := $(VENV)/.installed-eval
SYNTH := $(VENV)/.installed-synth
FORMAL := $(VENV)/.installed-formal
SOURCES := $(wildcard golden/*.py hdl/*.py hdl/edges/*.py flow/*.py)
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet

.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
.PHONY: all verilog run package export synth tables eval test verify formal lint bench clean distclean help

all: verilog run  ## the Verilog of the default core, and a photograph through the simulated hardware

verilog: $(BUILD)/cornerstream.v  ## build/cornerstream.v

$(BUILD)/cornerstream.v: $(SOURCES) | $(CORE)
	$(BIN)/cornerstream verilog -o $@

run: | $(CORE)  ## simulate IMAGE=photo.jpg (default: scikit-image's camera); more options in ARGS=
	$(BIN)/cornerstream simulate $(if $(IMAGE),"$(IMAGE)") --output $(BUILD) $(ARGS)

package: | $(CORE)  ## build/ip: the core with drivers, descriptions and an example
	$(BIN)/cornerstream package --output $(BUILD)/ip --force $(ARGS)

export: | $(CORE)  ## build/quartus: the core with a Quartus project for Cyclone IV GX
	$(BIN)/cornerstream export --output $(BUILD)/quartus --force $(ARGS)

synth: | $(SYNTH)  ## area on Cyclone IV by block, clock frequency on ECP5 as a stand-in
	$(BIN)/cornerstream synth $(ARGS)

tables: | $(SYNTH)  ## every figure of docs/comparison.md, measured anew: half an hour and more
	$(BIN)/cornerstream tables $(ARGS)

test: lint  ## ruff, mypy and all tests; options for pytest in ARGS=
	$(BIN)/python -m pytest -n auto $(ARGS)

verify: | $(TEST)  ## the emitted Verilog by others' bus models, at length, and the long proofs: a quarter of an hour
	$(BIN)/python -m pytest -m verify -n auto --dist loadgroup $(ARGS)

formal: | $(FORMAL)  ## every proof of docs/formal.md, with its covers and seeded faults: some minutes
	$(BIN)/python -m pytest -n auto -m "verify or not verify" tests/formal $(ARGS)

lint: | $(TEST)  ## ruff and mypy
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

eval: | $(EVAL)  ## how good the corners are, into build/evaluation: some minutes; ARGS=--quick for less
	$(BIN)/cornerstream eval --output $(BUILD)/evaluation $(ARGS)

bench: | $(EVAL)  ## speed of the golden model and of the simulators
	$(BIN)/cornerstream bench $(ARGS)

clean:  ## remove build/
	rm -rf $(BUILD)

distclean: clean  ## remove build/, the virtual environment and all that tools left here
	rm -rf $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis *.egg-info
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

help:  ## this list
	@sed -n 's/^\([a-z]*\):.*##  */\1|/p' Makefile | while IFS='|' read -r target text; do \
	    printf '  make %-10s %s\n' "$$target" "$$text"; done

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
	    found=$$(command -v $(PYTHON) >/dev/null && $(PYTHON) --version 2>&1); \
	    echo "Error: $(PYTHON) is $${found:-missing};" \
	         "allowed: Python 3.11 or newer. Try: make PYTHON=python3.11" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)

$(CORE): pyproject.toml | $(BIN)/python
	@echo "Installing into $(VENV)"
	$(PIP) --editable .
	@for compiler in "$${CXX%% *}" c++ g++ clang++; do \
	    if [ -n "$$compiler" ] && command -v "$$compiler" >/dev/null; then exit 0; fi; done; \
	    echo "No C++ compiler found: installing one from PyPI"; $(PIP) --editable '.[compiler]'
	@touch $@

$(TEST): pyproject.toml | $(CORE)
	$(PIP) --editable '.[test]'
	@touch $@

$(SYNTH): pyproject.toml | $(CORE)
	$(PIP) --editable '.[synth]'
	@touch $@

$(FORMAL): pyproject.toml | $(CORE)
	$(PIP) --editable '.[formal]'
	@touch $@

$(EVAL): pyproject.toml | $(CORE)
	$(PIP) --editable '.[eval]'
	@touch $@
