# make               set up, then analyse every configured campaign
# make quick         set up, then lint and the tests that take seconds
# make test          set up, then lint and every test
# make slurm         what jobs on a Slurm cluster need besides
# make peers         the engines of other fields that docs/validation.md compares, in an environment of their own
# make dist         wheel and sdist, in dist
# make docs         set up, then build the site in site/
# make test-cluster  tests on a real Slurm, where its programs are installed
PYTHON ?= python3
VENV := .venv
READY := $(VENV)/.ready
KERNEL := $(VENV)/.kernel
SLURM := $(VENV)/.slurm
PEERS := .venv-peers
export PATH := $(CURDIR)/$(VENV)/bin:$(PATH)

# The tests of a file share what they set up; tests/conftest.py puts long ones first, so that no process waits at the end.
TESTS := python -m pytest --numprocesses 2 --dist loadfile --no-loadscope-reorder

.PHONY: all setup slurm peers lint quick test tests docs test-cluster dist clean

all: setup
	snakemake

setup: $(READY) $(KERNEL)

$(READY): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "$(PYTHON): Python 3.11 or newer is needed; name one, as in make PYTHON=python3.12" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	@echo "The packages of requirements.lock are fetched and installed: one to five minutes without a word."
	@python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	python -m compileall -q -j 0 $(VENV)/lib src
	touch $@

# What a job asks of compiled code is compiled once here, before two jobs do so at the same time.
$(KERNEL): $(wildcard src/freerock/models/*.py src/freerock/models/*.csv) \
		src/freerock/rotation/beam_kernel.py src/freerock/runs/impact_kernel.py \
		src/freerock/runs/whitening.py src/freerock/compile.py $(READY)
	python -m freerock.compile
	touch $@

slurm: setup $(SLURM)

$(SLURM): profiles/slurm/requirements.lock $(READY)
	python -m pip install --quiet --disable-pip-version-check --require-hashes --no-deps -r $<
	touch $@

peers: setup $(PEERS)/.ready

$(PEERS)/.ready: requirements-peers.lock
	$(PYTHON) -m venv $(PEERS)
	$(PEERS)/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r $<
	touch $@

lint: setup
	ruff check .
	ruff format --check .
	mypy
	lint-imports --no-cache --no-logo
	snakefmt --check Snakefile workflow
	snakemake --lint

quick: lint
	$(TESTS) -m "not slow"

# mypy keeps one core busy for half a minute: the tests begin beside it.
test: setup
	@$(MAKE) --no-print-directory --jobs 2 lint tests

tests: setup
	$(TESTS)

docs: setup
	python -m freerock_bench.site

test-cluster: setup $(SLURM)
	python -m pytest tests/cluster

# The wheel is built from the sdist, which so holds all that it needs.
dist: setup
	rm -rf build dist
	python -c 'from setuptools.build_meta import build_sdist; build_sdist("dist")'
	python -m pip wheel --quiet --disable-pip-version-check --no-deps --no-build-isolation --wheel-dir dist dist/*.tar.gz

clean:
	rm -rf $(VENV) $(PEERS) .snakemake build dist results site
