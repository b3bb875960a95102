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
DOCS := $(VENV)/.installed-docs
SYNTH := $(VENV)/.installed-synth
FORMAL := $(VENV)/.installed-formal
SOURCES := $(shell find golden hdl flow -name "*.py")
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet

LOWEST := $(BUILD)/lowest
LOWEST_BIN := $(LOWEST)/bin
# what the versions of other people's packages can break, as far as it is quick
LOWEST_TESTS := tests/golden $(patsubst %,tests/cornerstream/test_%.py,bad_input commands files images \
    images_depth images_kinds package process quartus) tests/sim/test_cache.py tests/sim/test_compiler.py \
    'tests/sim/test_waves.py::test_waves_of_the_first_clocks[compiled]'
# where no C++ compiler is found, one comes from PyPI
COMPILER = $(shell for compiler in "$${CXX%% *}" c++ g++ clang++; do \
    if [ -n "$$compiler" ] && command -v "$$compiler" >/dev/null; then exit; fi; done; echo '[compiler]')

# A variable that changes nothing is a mistake: ARGS and IMAGE where a goal hands them on, the others always.
# Whatever else is to reach the tools comes before `make`, in the environment.
GOALS := $(or $(MAKECMDGOALS),all)
WITH_IMAGE := all run
WITH_ARGS := $(WITH_IMAGE) package export synth compare test verify formal eval bench lowest
ALLOWED := BUILD CORNERSTREAM_CACHE CXX PYTHON VENV \
    $(if $(filter $(WITH_ARGS),$(GOALS)),ARGS) $(if $(filter $(WITH_IMAGE),$(GOALS)),IMAGE)
EMPTY :=
# make writes a blank within a value as backslash and blank
GIVEN := $(foreach word,$(subst \$(EMPTY) ,,$(MAKEOVERRIDES)),$(firstword $(subst =, ,$(subst :, ,$(word)))))
UNKNOWN := $(filter-out $(ALLOWED),$(GIVEN))
ifneq ($(UNKNOWN),)
$(error $(firstword $(UNKNOWN)) changes nothing in 'make $(GOALS)'; allowed: $(sort $(ALLOWED)))
endif

.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
.PHONY: all verilog run package export synth compare eval test lowest verify formal lint docs bench clean distclean help

all: verilog run  ## the Verilog of the default core, and a photograph through the simulated hardware

verilog: $(BUILD)/cornerstream.v  ## build/cornerstream.v

$(BUILD)/cornerstream.v: $(SOURCES) | $(CORE)
	$(BIN)/cornerstream verilog -o $@

# two profiles, unless ARGS names some
PROFILES := $(if $(findstring --profile,$(ARGS)),,--profile robust --profile paper)

run: | $(CORE)  ## profiles robust and paper on IMAGE=photo.jpg (default: scikit-image's camera), side by side; options in ARGS=
	$(BIN)/cornerstream simulate $(if $(IMAGE),"$(IMAGE)") --output $(BUILD) $(PROFILES) $(ARGS)

package: | $(CORE)  ## build/ip: the core with drivers, descriptions and an example
	$(BIN)/cornerstream package --output $(BUILD)/ip --force $(ARGS)

export: | $(CORE)  ## build/quartus: the core with a Quartus project for Cyclone IV GX
	$(BIN)/cornerstream quartus export --output $(BUILD)/quartus --force $(ARGS)

synth: | $(SYNTH)  ## area on Cyclone IV by block, clock frequency on ECP5 as a stand-in
	$(BIN)/cornerstream synth $(ARGS)

compare: | $(SYNTH)  ## every figure of docs/results/comparison.md, measured again: hours
	$(BIN)/cornerstream compare $(ARGS)

test: lint  ## ruff, mypy and all tests; options for pytest in ARGS=
	$(BIN)/python -m pytest -n auto --dist worksteal --durations=10 $(ARGS)

lowest: $(LOWEST)/.installed  ## tests with the lowest versions that pyproject.toml allows, in an environment of their own
	$(LOWEST_BIN)/python -m pytest -n auto $(LOWEST_TESTS) $(ARGS)

verify: | $(TEST)  ## what `make test` leaves out: more builds, bus models at length, long proofs: a quarter of an hour
	$(BIN)/python -m pytest -m verify -n auto --dist loadgroup --durations=10 $(ARGS)

formal: | $(FORMAL)  ## every proof of docs/explanation/formal.md, with its covers and seeded faults: some minutes
	$(BIN)/python -m pytest -n auto -m "verify or not verify" tests/formal $(ARGS)

lint: | $(TEST)  ## ruff and mypy
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: | $(DOCS)  ## all pages as a static site in build/site; a warning is an error
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --site-dir $(abspath $(BUILD))/site
	@echo "Written: $(BUILD)/site/index.html"

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
	$(if $(COMPILER),@echo "No C++ compiler found: installing one from PyPI")
	$(PIP) --editable '.$(COMPILER)'
	@touch $@

$(TEST): pyproject.toml | $(CORE)
	$(PIP) --editable '.[test,docs]'
	@touch $@

$(SYNTH): pyproject.toml | $(CORE)
	$(PIP) --editable '.[synth]'
	@touch $@

$(FORMAL): pyproject.toml | $(CORE)
	$(PIP) --editable '.[formal]'
	@touch $@

$(DOCS): pyproject.toml | $(CORE)
	$(PIP) --editable '.[docs]'
	@touch $@

$(EVAL): pyproject.toml | $(CORE)
	$(PIP) --editable '.[eval]'
	@touch $@

$(LOWEST)/.installed: pyproject.toml .ci/lowest.py | $(BIN)/python
	$(BIN)/python -m venv --clear $(LOWEST)
	$(BIN)/python .ci/lowest.py > $(LOWEST)/constraints.txt
	$(LOWEST_BIN)/python -m pip --disable-pip-version-check install --quiet --constraint $(LOWEST)/constraints.txt \
	    --editable '.$(COMPILER)' pytest pytest-xdist hypothesis matplotlib opencv-python-headless
	@touch $@
