# make               set up, then analyse every configured campaign
# make quick         set up, then lint and the tests that take seconds
# make test          set up, then lint and every test
# make slurm         what jobs on a Slurm cluster need besides
# make peers         the engines of other fields that docs/benchmark.md compares, in an environment of their own
# make test-cluster  tests on a real Slurm, where its programs are installed
PYTHON ?= python3
VENV := .venv
READY := $(VENV)/.ready
KERNEL := $(VENV)/.kernel
SLURM := $(VENV)/.slurm
PEERS := .venv-peers
export PATH := $(CURDIR)/$(VENV)/bin:$(PATH)

# The tests of a file share what they set up.
TESTS := python -m pytest --numprocesses 2 --dist loadfile

.PHONY: all setup slurm peers lint quick test test-cluster clean

all: setup
	snakemake

setup: $(READY) $(KERNEL)

$(READY): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "$(PYTHON): Python 3.11 or newer is needed; name one, as in make PYTHON=python3.12" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	python -m compileall -q -j 0 $(VENV)/lib src
	touch $@

# The integrator is compiled once here, before two jobs do so at the same time.
$(KERNEL): src/freerock/models/kernel.py $(READY)
	python -c 'from freerock.models import block, simulate; simulate.simulate("winkler", \
		block.Block(1, 0.2, 1), {"k": 1e6, "c": 1e3}, [0, 0.01], theta0=0.1)'
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

test: lint
	$(TESTS)

test-cluster: setup $(SLURM)
	python -m pytest tests/cluster

clean:
	rm -rf $(VENV) $(PEERS) .snakemake results
