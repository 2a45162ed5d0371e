PYTHON ?= python3
EPISODES ?= 8
READY := .venv/.ready

export OMP_NUM_THREADS ?= 1
export OMP_WAIT_POLICY ?= PASSIVE

# make controls: docs/curiosity-controls.md; every sweep has its folder, so the same line goes on after an interruption.
SCALE ?= cpu
CONTROLS = outputs/controls/$(SCALE)
SWEEP = .venv/bin/curionav explore -m launcher=cores
SMOKE = 'seed=range(2)' loop.episodes=2 loop.steps=60 loop.iterations=4
ROOM = env=small_room $(if $(filter smoke,$(SCALE)),$(SMOKE),'seed=range(5)' loop.episodes=60)
FLAT = env=apartment_0 $(if $(filter smoke,$(SCALE)),$(SMOKE),'seed=range(5)' loop.episodes=100)
WANDERERS = agent=random,sticky,bounce,frontier

.PHONY: help setup explore controls test lint clean

help:
	@echo "make explore   set up, then watch LBS Dreamer explore a room, beside random and bounce"
	@echo "make controls  does surprise beat its controls? hours; SCALE=smoke: minutes, to see that it works"
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

controls: $(READY)
	$(SWEEP) $(ROOM) $(WANDERERS) hydra.sweep.dir=$(CONTROLS)/room_wanderers
	$(SWEEP) $(ROOM) experiment=curiosity_controls hydra.sweep.dir=$(CONTROLS)/room_learners
	$(SWEEP) $(FLAT) $(WANDERERS) hydra.sweep.dir=$(CONTROLS)/flat_wanderers
	$(SWEEP) $(FLAT) experiment=curiosity_controls agent.curiosity=lbs,picture_count,shuffled hydra.sweep.dir=$(CONTROLS)/flat_learners
	.venv/bin/curionav compare $(CONTROLS)/room_* $(CONTROLS)/flat_* out=$(CONTROLS)/compare

test: $(READY)
	.venv/bin/python -m pytest -q

lint: $(READY)
	.venv/bin/ruff check .
	.venv/bin/mypy

clean:
	rm -rf .venv build dist .pytest_cache .ruff_cache .mypy_cache
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +
