# make simulate: environment, FMU, the paper's two scenarios      make test: everything that CI checks
# make bench: all measurements beside floors and peers, into docs/benchmarks.md
# make torture: the torture tests' long form, half an hour on two cores; interrupted, it goes on
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: simulate test system fmu lint coverage mutation traffic clean torture bench
.DEFAULT_GOAL := simulate

simulate: fmu
	$(BIN)/python examples/01_paper_scenarios.py dist/PspPlatoon.fmu out

test: system $(VENV)/.test fmu lint
	$(BIN)/python -m pytest -n 2

# what single tests need from the system: installed as root on Debian, else those tests are skipped
system: | $(BIN)/python
	$(BIN)/python tests/system_packages.py

bench: $(VENV)/.test
	PYTHONPATH=tests $(BIN)/python -m benchmarks

torture: $(VENV)/.test
	PYTHONPATH=tests $(BIN)/python -m torture

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

# the runs in SUMO behind docs/traffic.md from scratch, tables and pictures: about three quarters of an hour
RESULTS := benchmarks/results
traffic: $(VENV)/.test
	rm -f $(RESULTS)/traffic.json $(RESULTS)/traffic_sweep_*.json
	$(BIN)/psp sumo --runtime native --output $(RESULTS)/traffic.json
	$(BIN)/psp sumo profile --runtime native --output $(RESULTS)/traffic.json --plot docs/images/traffic_profile.png
	$(BIN)/psp sumo highway --sweep --runtime native --output $(RESULTS)/traffic_sweep_highway.json \
		--plot docs/images/traffic_sweep_highway.png
	$(BIN)/psp sumo stop-and-go --sweep --starts 5 --runtime native --output $(RESULTS)/traffic_sweep_wave.json \
		--plot docs/images/traffic_sweep_wave.png
	rm -f docs/images/traffic_*.svg

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
