# Everything happens in .venv, made on first use and renewed when pyproject.toml or constraints.txt change.
.DEFAULT_GOAL := help
.PHONY: help demo test bench lint clean

BIN := .venv/bin
READY := .venv/.ready
WORKERS ?= auto
# One thread of the linear algebra for each test process: more of them only wait for each other.
export OPENBLAS_NUM_THREADS ?= 1
PYTEST_ARGS ?=

help: ## this list
	@echo "make demo   a foraging trip and its way home: figures and tables in out/"
	@echo "make test   style, types and the whole test suite"
	@echo "make bench  how fast each hot path is, beside a plain version of it"
	@echo "make lint   style and types only"
	@echo "make clean  remove .venv, caches and build products; out/ stays"

demo: $(READY)
	$(BIN)/insectnav home --out out/random-trip
	$(BIN)/python examples/random_trips.py

test: lint
	$(BIN)/python -m pytest -n $(WORKERS) --maxprocesses 8 --dist worksteal $(PYTEST_ARGS)

bench: $(READY)
	@set -e; for script in $(sort $(wildcard benchmarks/[!_]*.py)); do \
	  echo "== $$script"; PYTHONPATH=tests $(BIN)/python $$script; \
	done

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

clean:
	rm -rf .venv build dist .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find src tests benchmarks examples -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

$(READY): pyproject.toml constraints.txt
	@set -e; \
	is_new_enough='import sys; sys.exit(sys.version_info < (3, 11))'; \
	if ! $(BIN)/python -c "import pip; $$is_new_enough" 2>/dev/null; then \
	  chosen=; \
	  for candidate in python3 python3.13 python3.12 python3.11; do \
	    if $$candidate -c "$$is_new_enough" 2>/dev/null; then chosen=$$candidate; break; fi; \
	  done; \
	  if [ -z "$$chosen" ]; then \
	    echo "insectnav needs Python 3.11 or newer; none of python3, python3.13, python3.12, python3.11 is." >&2; exit 1; \
	  fi; \
	  echo "making .venv with $$($$chosen --version)"; \
	  $$chosen -m venv --clear .venv; \
	fi; \
	echo "installing the packages of constraints.txt (a minute or two the first time)"; \
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable ".[dev]"; \
	touch $@
