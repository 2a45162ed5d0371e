PYTHON ?= python3
EPISODES ?= 8
READY := .venv/.ready

export OMP_NUM_THREADS ?= 1
export OMP_WAIT_POLICY ?= PASSIVE

.PHONY: help setup explore test lint clean

help:
	@echo "make explore   set up, then watch LBS Dreamer explore a room, beside random and bounce"
	@echo "make test      set up, then run the tests"
	@echo "make setup     virtual environment in .venv, versions pinned by constraints.txt"
	@echo "make lint      ruff and mypy"
	@echo "make clean     remove .venv and caches; outputs/ stays"

setup: $(READY)

# The stamp is written last: an interrupted installation is taken up again.
$(READY): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "Python 3.11 or newer is needed; name one: make PYTHON=python3.12"; exit 1; }
	$(PYTHON) -m venv .venv
	.venv/bin/pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

explore: $(READY)
	.venv/bin/curionav explore -m env=small_room agent=lbs_dreamer,random,bounce scale=cpu loop.episodes=$(EPISODES)

test: $(READY)
	.venv/bin/python -m pytest -q

lint: $(READY)
	.venv/bin/ruff check .
	.venv/bin/mypy

clean:
	rm -rf .venv build dist .pytest_cache .ruff_cache .mypy_cache
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +
