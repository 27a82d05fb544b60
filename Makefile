# taut: make (build), make demo, make test, make bench, make python, make deps. On a fresh machine with Debian 12 or 13 `make demo` and
# `make test` install what is missing and need nothing else.

BUILD := build/release
SUDO := $(shell [ "$$(id -u)" = 0 ] || echo sudo)
PYTHON_PACKAGES := python3-dev pybind11-dev python3-numpy python3-pytest
PACKAGES := g++ cmake ninja-build pkg-config libopenmesh-dev libosd-dev libembree-dev libglm-dev libopenimageio-dev openimageio-tools \
            libopencolorio-dev libtbb-dev libtomlplusplus-dev libcli11-dev libfmt-dev nlohmann-json3-dev libxxhash-dev libboost-dev catch2 \
            ffmpeg gnuplot-nox fonts-dejavu-core $(PYTHON_PACKAGES)
MISSING := $(shell for p in $(PACKAGES); do dpkg-query -W -f='$${Status}' $$p 2>/dev/null | grep -q 'install ok installed' || echo $$p; done)

.PHONY: all build command build-time deps python blender-addon export-tools demo test bench debian13 debian13-blender debian13-bench sanitize fuzz-tools fuzz fuzz-coverage format clean

all: build

build: deps
	cmake --preset release
	cmake --build --preset release

deps:
ifneq ($(MISSING),)
	$(SUDO) apt-get update -qq
	$(SUDO) env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $(MISSING)
endif

# The package taut for the system's Python: import taut. PYTHON_FOLDER=... puts it elsewhere.
PYTHON_FOLDER = $(shell /usr/bin/python3 -c "import sysconfig; print(sysconfig.get_path('platlib'))")
python: deps
	cmake --preset release
	cmake --build --preset release --target taut_python
	mkdir -p "$(PYTHON_FOLDER)" 2>/dev/null || $(SUDO) mkdir -p "$(PYTHON_FOLDER)"
	$(if $(shell test -w "$(PYTHON_FOLDER)" && echo yes),,$(SUDO)) cmake --install $(BUILD) --component python --prefix "$(abspath $(PYTHON_FOLDER))"
	PYTHONPATH="$(abspath $(PYTHON_FOLDER))" /usr/bin/python3 -c "import taut; print('taut', taut.__version__, 'in', taut.__path__[0])"

# The Blender add-on as a file that Blender installs.
blender-addon:
	mkdir -p build
	rm -f build/taut_gloss.zip
	cd apps/blender && /usr/bin/python3 -m zipfile -c ../../build/taut_gloss.zip taut_gloss/
	@echo build/taut_gloss.zip

# What the tests of `taut export` read its files with; without it they say that they were skipped.
export-tools:
	$(SUDO) env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends python3-numpy blender nodejs npm
	npm install --no-audit --no-fund --prefix build/tools gltf-validator@2.0.0-dev.3.10

# The command alone: no tests, benches or Python.
command: deps
	cmake --preset release
	cmake --build --preset release --target taut_command

# What a build from nothing takes: the command, then tests, charts, benches and Python. OPTIONS=-DTAUT_UNITY=OFF compares.
build-time: export CCACHE_DISABLE := 1
build-time: deps
	rm -rf build/timed
	cmake -S . -B build/timed -G Ninja -D CMAKE_BUILD_TYPE=Release $(OPTIONS) >/dev/null
	@bash -c 'TIMEFORMAT="the command: %U + %S s of processor time, %R s"; time cmake --build build/timed --target taut_command >/dev/null'
	@bash -c 'TIMEFORMAT="the rest: %U + %S s of processor time, %R s"; time cmake --build build/timed >/dev/null'

demo: command
	apps/demo/demo.sh $(BUILD)/taut out/demo

test: build
	ctest --preset release -j $$(nproc)

bench: build
	$(BUILD)/taut_bench --output build/bench.json --chart build/bench $(if $(shell command -v blender),--cycles --equal-error)

# Debian 13 in a root of its own (.ci/debian13; as root): the demo and the tests; those that want Blender too; both systems' benches.
DEBIAN13 := build/debian13
debian13:
	.ci/debian13 $(if $(MIRROR),--mirror $(MIRROR)) $(DEBIAN13)
debian13-blender:
	.ci/debian13 --blender $(if $(MIRROR),--mirror $(MIRROR)) $(DEBIAN13)
debian13-bench: build
	.ci/debian13 --bench $(if $(MIRROR),--mirror $(MIRROR)) $(DEBIAN13)

# The whole suite under the address and undefined behaviour sanitizers.
sanitize: deps
	cmake --preset sanitize
	cmake --build --preset sanitize
	ctest --preset sanitize -j $$(nproc)

fuzz-tools: deps
	$(SUDO) env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends clang-14 libclang-rt-14-dev llvm-14

# Every harness for FUZZ_SECONDS or FUZZ_RUNS (docs/limits.md). Corpora stay in build/corpora, findings in build/findings.
fuzz: fuzz-tools
	cmake --preset fuzz
	cmake --build --preset fuzz
	tests/fuzz/run.sh build/fuzz build/corpora build/findings

# How many lines of src/ the corpora reach.
fuzz-coverage: fuzz-tools
	cmake --preset fuzz-coverage
	cmake --build --preset fuzz-coverage
	tests/fuzz/coverage.sh build/fuzz-coverage build/corpora

format:
	clang-format -i $$(git ls-files '*.h' '*.cpp')

clean:
	rm -rf build out
