# make demo, make test: each does all the set-up it needs. On Debian 12 or newer, as root or with sudo.
.DEFAULT_GOAL := help
.PHONY: help setup kernels with-tests demo test test-slow test-latest test-install docs stress bench bench-engine bench-fem test-mpi player lint types layers clean

help:            ## this list
	@sed -n 's/^\([a-z-]*\): *\(.*\)## */  make \1\t/p' Makefile | expand -t 22

setup:           ## Debian's FEniCSx and gmsh, and the environment .venv
	@bash .ci/setup.sh

kernels: setup   ## build the solver for this machine: what is there already is left
	@bash .ci/in-env .venv python -m kanefe.kernels.compiler.build

with-tests: kernels  # what tests, documents and benchmarks use beyond kanefe's own packages
	@bash .ci/setup.sh test

demo: setup      ## set up, then run the demo (files under out/)
	@bash .ci/in-env .venv kanefe demo

test: with-tests ## set up, then run all the tests, on two cores
	@KANEFE_TEST_REQUIRE="fenicsx gmsh dask urdf mjcf collision" bash .ci/in-env .venv python -m pytest -q -n 2 --dist loadfile

test-slow: with-tests ## the long cases that `make test` leaves out, on two cores
	@KANEFE_TEST_REQUIRE="fenicsx gmsh dask urdf mjcf collision" bash .ci/in-env .venv python -m pytest -q -n 2 --dist loadfile -m slow

test-mpi: with-tests ## bodies made by two processes of MPI, on the dolfinx of .venv and, where it is set up, of .venv-latest
	@for env in .venv $(wildcard .venv-latest); do bash .ci/in-env $$env python -m pytest -q -m mpi tests/fem/processes || exit 1; done

test-latest:     ## the finite element tests on the newest dolfinx, in .venv-latest (Python >= 3.12)
	@bash .ci/test-latest

test-install:    ## pip install ., the sdist and its wheel, each in a clean environment, and what they run
	@bash .ci/test-install

docs: with-tests ## the documents as a site, build/docs/html; runs their snippets and all examples
	@bash .ci/docs

stress: with-tests  ## all robustness cases in full (40 minutes; OPTIONS="--quick --html FILE drift": some of them, shorter)
	@bash .ci/in-env .venv python tests/robustness/stress.py $(OPTIONS)

bench: with-tests   ## error against CPU time, and figures against goals and Exudyn (OPTIONS="--quick --peer --png FILE", "--figures")
	@bash .ci/in-env .venv python tests/benchmarks/bench.py $(OPTIONS)

bench-engine: with-tests  ## the engine's figures against Exudyn, Pinocchio and MuJoCo (some minutes; OPTIONS="--quick --json FILE")
	@bash .ci/in-env .venv python tests/benchmarks/peer_engine.py $(OPTIONS)

bench-fem: with-tests  ## the finite element side against Exudyn and dolfinx (some minutes; OPTIONS="--large --json FILE")
	@bash .ci/in-env .venv python tests/benchmarks/fe_pipeline.py $(OPTIONS)

player:          ## build the page that shows runs from its source and three.js of npm (needs node)
	@bash .ci/player

lint:            ## ruff, mypy and the contracts of the layers
	@bash .ci/setup.sh dev
	@bash .ci/in-env .venv ruff check .
	@$(MAKE) --no-print-directory -j2 --output-sync=target types layers

types:
	@bash .ci/in-env .venv mypy

layers:
	@bash .ci/in-env .venv lint-imports --no-cache

clean:           ## remove the environments, caches and results
	rm -rf .venv .venv-latest .venv-docs .venv.lock out build *.egg-info fem/*.egg-info
	rm -rf .pytest_cache .ruff_cache .mypy_cache .hypothesis
	rm -rf docs/_generated docs/gallery docs/reference/generated
	find kanefe fem docs tests examples meshes -name __pycache__ -type d -prune -exec rm -rf {} +
