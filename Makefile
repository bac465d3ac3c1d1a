# The only list of commands; CI calls these too. `make help` prints it.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
OUT    ?= out
SHARED ?=
CORE   := $(shell find rust -name '*.rs') Cargo.toml Cargo.lock rust/graft-core/Cargo.toml rust/graft-py/Cargo.toml

.DEFAULT_GOAL := help
.PHONY: help demo test test-slow lint docs bench verify-formats wheel clean

help:  ## Print this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/\t/' | expand -t 16

demo: $(VENV)/.demo  ## Set up, then transfer contacts to unseen objects; pictures, page and JSON in out/
	$(BIN)/graft demo --out $(OUT)

test: $(VENV)/.dev  ## Set up, then run the tests (Rust, Python, doctests, README, examples)
	cargo test --workspace --quiet
	$(BIN)/pytest -n auto -m "not slow"

test-slow: $(VENV)/.dev  ## The tests that `make test` leaves out
	$(BIN)/pytest -n auto -m slow

lint: $(VENV)/.dev  ## Formatting, clippy, ruff, mypy, stubtest, import contract
	cargo fmt --check
	cargo clippy --workspace --all-targets --quiet -- -D warnings
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest graft._core --mypy-config-file pyproject.toml
	$(BIN)/lint-imports

docs: $(VENV)/.docs  ## Build the documentation into docs/_build
	$(BIN)/sphinx-build -q -W -b html docs docs/_build/html

bench: $(VENV)/.dev  ## Benchmarks against peers; SHARED=folder of labelled objects adds real parts
	$(BIN)/python benches/geometry.py $(SHARED)
	$(BIN)/python benches/descriptor.py $(if $(SHARED),--objects $(SHARED))
	$(BIN)/python benches/transport.py
	$(BIN)/python benches/pipeline.py $(SHARED)
	$(BIN)/python benches/simulation.py
	$(BIN)/python benches/generation.py

verify-formats: $(VENV)/.dev  ## robomimic's and LeRobot's own loaders read our files (downloads 3 GB, needs 6); WORK=folder
	$(BIN)/python benches/verify_formats.py $(if $(WORK),--work $(WORK))

wheel: $(VENV)/.dev  ## Build the wheel into dist/
	$(BIN)/maturin build --release --out dist

clean:  ## Remove everything that was built
	rm -rf $(VENV) target dist out docs/_build docs/examples docs/sg_execution_times.rst

# --- set-up -----------------------------------------------------------------------------------------------------

$(VENV)/bin/python:
	@PYTHON=$(PYTHON) .ci/system-packages
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --upgrade pip

$(VENV)/.demo: $(VENV)/bin/python pyproject.toml $(CORE)
	$(BIN)/pip install --quiet --editable '.[demo]'
	@touch $@

$(VENV)/.dev: $(VENV)/.demo
	$(BIN)/pip install --quiet --group dev
	@touch $@

$(VENV)/.docs: $(VENV)/.dev
	$(BIN)/pip install --quiet --group docs
	@touch $@
