# Two commands on a fresh machine: `make run`, `make test`. Needs git, make, a C compiler, cargo and
# Python >= 3.11 with venv; everything else lands in .venv and target here.

UV_VERSION := 0.13.9
UV := .uv/bin/uv
export UV_PYTHON_DOWNLOADS := never
export UV_SYSTEM_CERTS := true
PY := .venv/bin/python
CAIRN := .venv/bin/cairn
PYTHON_SOURCES := python tests examples docs/sitegen

.PHONY: run test test-rust test-python test-browser test-slow bench docs lint format setup lock clean

run: setup
	$(CAIRN) run office

test: setup test-rust test-python

test-rust:
	cargo test --workspace --quiet

test-python: setup
	$(PY) -m pytest

# The console in a real browser, all of it: needs a Chromium on the path (Debian: chromium).
test-browser: setup
	$(PY) -m pytest -m "slow or not slow" tests/test_console_browser.py

# Minutes: every shipped scenario with ten seeds, and the table of how each went.
test-slow: setup
	$(PY) -m pytest -m slow

# An hour: every kind of map at 1024² and 4096², beside the planners of others. `cairn bench plan --quick`: a minute.
bench: setup
	@$(UV) pip install --quiet --python $(PY) --constraint constraints.txt --editable ".[sim,bench]" --group dev
	$(CAIRN) bench plan

# The site, into `site/`, from the repository alone. RUST=1: with the documentation of the crate.
docs: setup
	@$(UV) pip install --quiet --python $(PY) --constraint constraints.txt --editable ".[sim,docs]" --group dev
	PYTHONPATH=docs $(PY) -m sitegen $(if $(RUST),--rust)

lint: setup
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --quiet -- -D warnings
	$(PY) -m ruff format --check $(PYTHON_SOURCES)
	$(PY) -m ruff check $(PYTHON_SOURCES)
	$(PY) -m pyright

format: setup
	cargo fmt --all
	$(PY) -m ruff format $(PYTHON_SOURCES)
	$(PY) -m ruff check --fix $(PYTHON_SOURCES)

# uv rebuilds the brain whenever a Rust source changed (cache-keys in pyproject.toml).
setup: .venv/bin/python
	@$(UV) pip install --quiet --python $(PY) --constraint constraints.txt --editable ".[sim,console]" --group dev

.venv/bin/python: | $(UV)
	$(UV) venv --quiet --python "$$(command -v python3)" .venv

$(UV):
	python3 -m venv .uv
	.uv/bin/python -m pip install --quiet --disable-pip-version-check uv==$(UV_VERSION)

# Pins every version for setup. Run after changing a dependency, and commit the result.
lock: | $(UV)
	$(UV) pip compile --quiet --universal --python-version 3.11 --all-extras --group dev \
		--no-emit-index-url --no-header --no-annotate pyproject.toml --output-file constraints.txt

clean:
	rm -rf .venv .uv target runs site
