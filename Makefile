# make               set up, then analyse every configured campaign
# make quick         set up, then lint and the tests that take seconds
# make test          set up, then lint and every test
# make slurm         what jobs on a Slurm cluster need besides
# make peers         the engines of other fields that docs/validation.md compares, in an environment of their own
# make dist          wheel and sdist, in dist
# make evidence      studies whose tables are older than the code they judge, then the numbers of the documentation
# make docs          set up, then build the site in site/
# make test-cluster  tests on a real Slurm, where its programs are installed
# make lock          renew the pinned versions
PYTHON ?= python3
VENV := .venv
READY := $(VENV)/.ready
BYTES := $(VENV)/.bytes
DEVELOPMENT := $(VENV)/.development
KERNEL := $(VENV)/.kernel
SLURM := $(VENV)/.slurm
PEERS := .venv-peers
export PATH := $(CURDIR)/$(VENV)/bin:$(PATH)
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export UV_HTTP_TIMEOUT := 20

# The tests of a file share what they set up; tests/conftest.py puts long ones first, so that no process waits at the end.
TESTS := python -m pytest --numprocesses 2 --dist loadfile --no-loadscope-reorder

# The packages of a lock, by uv where it can be had, else by pip. Both check the hashes.
UV := uv pip install --python $(VENV) --quiet --no-cache --require-hashes --no-deps
PIP := python -m pip install --quiet --no-compile --require-hashes --no-deps
COMPILE := uv pip compile --quiet --upgrade --universal --python-version 3.11 --generate-hashes --no-annotate --no-header

.PHONY: all setup warm slurm peers lint quick test tests evidence docs test-cluster dist lock clean

all: setup
	snakemake

# Each keeps one core busy.
setup: $(READY)
	@$(MAKE) --no-print-directory --jobs 2 warm

warm: $(BYTES) $(KERNEL)
	@:

$(READY): requirements.lock requirements-uv.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "$(PYTHON): Python 3.11 or newer is needed; name one, as in make PYTHON=python3.12" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	@echo "The packages of requirements.lock are fetched and installed: a minute or two without a word."
	@$(PIP) -r requirements-uv.lock || echo "There is no uv; pip takes longer."
	@$(UV) -r requirements.lock || $(PIP) -r requirements.lock
	@python -m pip install --quiet --no-deps --no-build-isolation --editable .
	touch $@

# Without it every process compiles what it imports where PYTHONDONTWRITEBYTECODE is set.
$(BYTES): $(READY)
	python -m compileall -q -x '/tests?/' $(VENV)/lib src
	touch $@

# What a job asks of compiled code is compiled once here, before two jobs do so at the same time.
$(KERNEL): $(wildcard src/freerock/models/*.py src/freerock/models/*.csv) \
		src/freerock/rotation/beam_kernel.py src/freerock/runs/impact_kernel.py \
		src/freerock/compile.py $(READY)
	python -m freerock.compile
	touch $@

$(DEVELOPMENT): requirements-dev.lock $(READY)
	@$(UV) -r $< || $(PIP) -r $<
	touch $@

slurm: setup $(SLURM)

$(SLURM): profiles/slurm/requirements.lock $(READY)
	$(UV) -r $< || $(PIP) -r $<
	touch $@

peers: setup $(PEERS)/.ready

$(PEERS)/.ready: requirements-peers.lock
	$(PYTHON) -m venv $(PEERS)
	$(PEERS)/bin/python -m pip install --quiet --require-hashes -r $<
	touch $@

lint: setup $(DEVELOPMENT)
	ruff check .
	ruff format --check .
	mypy
	lint-imports --no-cache --no-logo
	snakefmt --check Snakefile workflow
	snakemake --lint

# mypy keeps one core busy for half a minute: the tests begin beside it.
quick: setup $(DEVELOPMENT)
	@$(MAKE) --no-print-directory --jobs 2 lint tests WHICH='-m "not slow" tests/unit tests/physics src'

test: setup $(DEVELOPMENT)
	@$(MAKE) --no-print-directory --jobs 2 lint tests

tests: setup $(DEVELOPMENT)
	$(TESTS) $(WHICH)

evidence: setup peers $(DEVELOPMENT)
	python -m freerock_bench.evidence

# Each table of the studies says whether the code that it judges is newer.
docs: setup $(DEVELOPMENT)
	python -m freerock_bench.evidence none
	python -m freerock_bench.site

test-cluster: setup $(DEVELOPMENT) $(SLURM)
	python -m pytest tests/cluster

# The wheel is built from the sdist, which so holds all that it needs.
dist: setup
	rm -rf build dist
	python -c 'from setuptools.build_meta import build_sdist; build_sdist("dist")'
	python -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir dist dist/*.tar.gz

# requirements-dev.lock has what requirements.lock lacks.
lock: setup
	$(COMPILE) --extra editable -o requirements.lock pyproject.toml
	$(COMPILE) --extra development --extra site -c requirements.lock -o requirements-dev.lock pyproject.toml \
		$$(sed -n 's/^\([^ =]*\)==.*/--no-emit-package \1/p' requirements.lock | sort -u)
	echo uv | $(COMPILE) -o requirements-uv.lock -

clean:
	rm -rf $(VENV) $(PEERS) .snakemake build dist results site
