# Two commands do all the set-up: `make demo` and `make test`. `make check` is exactly CI.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

# two at once: the tests take most of make check; a file of tests stays in one process, so that no fixture is made twice
PYTEST_ARGS ?= -n 2 --dist loadscope

PIL_PROGRAMS := arm-none-eabi-gcc qemu-system-arm cppcheck

.PHONY: demo test check lint docs benchmark slow pil warmup clean

$(STAMP): pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(0 if sys.version_info >= (3, 11) else "Bitepoint needs Python 3.11 or newer; run make PYTHON=/path/to/python3.11")'
	test -d $(VENV) || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[dev]'
	touch $(STAMP)

warmup: $(STAMP)
	$(BIN)/bitepoint warmup

demo: warmup
	$(BIN)/bitepoint run dct-launch --out out/demo

test: $(STAMP)
	$(BIN)/python -m pytest -m 'not slow' --cov --cov-report=term $(PYTEST_ARGS)

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

docs: $(STAMP)
	$(BIN)/mkdocs build --strict --site-dir site

check: lint test docs

pil: $(STAMP)
	@for program in $(PIL_PROGRAMS); do command -v $$program > /dev/null || \
	    { echo "make pil needs $$program: apt-get install $$(tr '\n' ' ' < .ci/packages)" >&2; exit 1; }; done
	$(BIN)/python -m pytest -m pil

slow: $(STAMP)
	$(BIN)/python -m pytest -m slow

benchmark: $(STAMP)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[benchmark]'
	$(BIN)/python -m benchmarks

clean:
	rm -rf $(VENV) out site .pytest_cache .ruff_cache .hypothesis .coverage
