# make simulate: environment, FMU, the paper's two scenarios      make test: everything that CI checks
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: simulate test fmu lint coverage mutation clean
.DEFAULT_GOAL := simulate

simulate: fmu
	$(BIN)/python examples/01_paper_scenarios.py dist/PspPlatoon.fmu out

test: $(VENV)/.test fmu lint
	$(BIN)/python -m pytest -n 2

fmu: $(VENV)/.run
	$(BIN)/python build_fmu.py

lint: $(VENV)/.test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# which branches the tests reach; needs clang with llvm-cov for the C half
coverage: $(VENV)/.test
	$(BIN)/python tests/assurance/branches.py

# the model changed one place at a time: does a test notice?
mutation: $(VENV)/.test
	$(BIN)/python tests/assurance/mutants.py

# A stamp per set of extras: `make simulate` needs little, `make test` all that the tests drive.
$(VENV)/.run: pyproject.toml | $(BIN)/python
	PYTHONWARNINGS=ignore $(BIN)/python -m pip install --quiet --editable '.[report]'
	touch $@

$(VENV)/.test: pyproject.toml | $(BIN)/python
	PYTHONWARNINGS=ignore $(BIN)/python -m pip install --quiet --editable '.[report,film,offline,native,test]'
	touch $@ $(VENV)/.run

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)
	$@ -m pip install --quiet --upgrade pip

clean:
	rm -rf dist out build mutants *.egg-info .pytest_cache .hypothesis .mypy_cache .ruff_cache
