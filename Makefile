PYTHON ?= python3
EPISODES ?= 8
WORKERS ?= 2
READY := .venv/.ready

export OMP_NUM_THREADS ?= 1
export OMP_WAIT_POLICY ?= PASSIVE

# make controls: docs/curiosity-controls.md; every sweep has its folder, so the same line goes on after an interruption.
SCALE ?= cpu
ifeq ($(filter $(SCALE),smoke cpu paper),)
  $(error SCALE=$(SCALE) is not one of smoke, cpu, paper)
endif
CONTROLS = outputs/controls/$(SCALE)
SWEEP = .venv/bin/curionav explore -m launcher=cores
SMOKE = 'seed=range(2)' loop.episodes=2 loop.steps=80 loop.iterations=4
ROOM = env=small_room $(if $(filter smoke,$(SCALE)),$(SMOKE),'seed=range(5)' loop.episodes=60)
FLAT = env=apartment_0 $(if $(filter smoke,$(SCALE)),$(SMOKE),'seed=range(5)' loop.episodes=100)
BASELINES = agent=random,sticky,bounce,frontier
QUESTION = experiment=curiosity_controls

# make teach: docs/results.md, "What an explorer teaches its model". WORLD, EXPLORERS, SEEDS: another building, other
# explorers (names of agents, between spaces), another number of seeds.
WORLD ?= env=small_room
EXPLORERS ?= random bounce mapper cbet lbs_dreamer
SEEDS ?= $(if $(filter smoke,$(SCALE)),2,5)
TEACH = outputs/teach/$(SCALE)/$(subst =,_,$(subst $(empty) $(empty),_,$(patsubst env=%,%,$(WORLD))))
COLLECT = $(if $(filter smoke,$(SCALE)),loop.episodes=2 loop.steps=100 loop.iterations=4,loop.episodes=60)
LEARN = $(if $(filter smoke,$(SCALE)),loop.iterations=200 results.probe_every=1,)
comma = ,
empty =
joined = $(subst $(empty) $(empty),$(comma),$(strip $(1)))
COLLECTED = $(call joined,$(EXPLORERS:%=$(TEACH)/collected/%_$${seed}))


# make figures: every figure and table of the paper. Each line that it prints can be typed as it stands, and goes on
# where it was interrupted; a sweep that is whole is not run again.
FIG = outputs/figures/$(SCALE)
RUNS = $(FIG)/runs
CURIONAV = .venv/bin/curionav
RUN = $(CURIONAV) explore -m launcher=cores
COUNT = marking=landing denominator=visitable
ifeq ($(SCALE),smoke)
  OURS = $(THEIRS)
  THEIRS = 'seed=range(2)' $(TINY)
  SMALL = $(TINY)
  LARGE = $(TINY)
  MANY = 'seed=range(2)' $(TINY)
  TINY = loop.episodes=2 loop.steps=100 loop.iterations=2
  DOCKING = dock.requests=5 loop.steps=40
else ifeq ($(SCALE),paper)
  OURS = scale=paper loop.episodes=4000
  THEIRS = scale=paper loop.episodes=10000
  SMALL = scale=paper loop.episodes=1000
  LARGE = scale=paper loop.episodes=1200
  MANY = scale=paper loop.episodes=4000
  DOCKING = dock.requests=1000
else
  OURS = loop.episodes=100
  THEIRS = loop.episodes=100
  SMALL = loop.episodes=100
  LARGE = loop.episodes=100
  MANY = loop.episodes=100
  DOCKING = dock.requests=600
endif
SWEEPS = ours theirs small large
FIGURES = figure-apartments figure-small-room figure-large-lab figure-predictions figure-best figure-scenes figure-docking
TABLES = table-hyperparameters table-sizes table-docking

# make pretrained: one agent for the three apartments, docs/card.md. Explorers record them, one agent learns from all.
PRETRAINED = outputs/pretrained/$(SCALE)
NAME ?= apartments$(if $(filter smoke,$(SCALE)),_smoke)
APARTMENTS = env=apartment_0,apartment_1,apartment_2
SIZED = agent=lbs_dreamer 'agent.decoder_channels=[24,16]'
ifeq ($(SCALE),smoke)
  RECORDED = loop.episodes=2 loop.steps=100 loop.iterations=2
  LEARNED = loop.iterations=20
  MEASURED = loop.episodes=1 loop.steps=100
else
  RECORDED = loop.episodes=100
  LEARNED = loop.iterations=20000
  MEASURED = loop.episodes=5
endif

# make paper-length: docs/paper-length.md, in its order. make -j2 paper-length works at two lines at a time.
LENGTH = outputs/paper_length/$(if $(filter smoke,$(SCALE)),smoke,cpu)
IN_LAB = experiment=paper_length_lab $(SHORT)
IN_APARTMENT = experiment=paper_length_apartments $(SHORT)
SHORT = $(if $(filter smoke,$(SCALE)),loop.episodes=2 loop.steps=100 loop.iterations=2)
THRICE = 'seed=range($(if $(filter smoke,$(SCALE)),2,3))'
UNTRAINED = agent=bounce,sticky,random,mapper $(THRICE)
CBETS = agent=cbet,cbet_ego,cbet_lifelong
FURTHER = $(if $(filter smoke,$(SCALE)),,loop.episodes=10000)
LENGTHS = lab lab_untrained lab_shuffled lab_seed_1 lab_unchanged lab_unchanged_untrained lab_cbet \
	$(foreach n,0 1 2,apartment_$(n) apartment_$(n)_untrained apartment_$(n)_cbet) room

.PHONY: help setup explore controls teach pretrained test docs clients trackers ros-peer ros-explore lint clean figures cost comparison paper-vs-ours paper-length paper-length-figures $(FIGURES) $(TABLES)

help:
	@echo "make explore   set up, then run LBS Dreamer in a room, beside random and bounce"
	@echo "make controls  does surprise beat its controls? hours; SCALE=smoke: minutes, a trial run"
	@echo "make teach     what does each explorer teach a world model? hours; SCALE=smoke: minutes, a trial run"
	@echo "make pretrained  an agent trained in the apartments, for curionav evaluate pretrained=apartments: an hour"
	@echo "make figures   every figure and table of the paper: SCALE=smoke minutes, cpu hours, paper weeks on a GPU"
	@echo "               one of them: make $(FIGURES) $(TABLES)"
	@echo "make paper-length  the lab, the apartments and the small room to the paper's last step: days (SCALE=smoke: minutes)"
	@echo "make comparison  ours, C-BET and the baselines: SCALE=cpu, five seeds, hours"
	@echo "make test      set up, then run the tests on two cores (WORKERS=4: four)"
	@echo "make docs      write the reference pages, and these docs as a site: site/index.html"
	@echo "make clients   install Stable-Baselines3, torchrl, tianshou and Minari too, and train with them in every world"
	@echo "make ros-peer  install a simulated ROS 2 robot and rosbridge server; test robot=rosbridge and serve on them"
	@echo "make setup     virtual environment in .venv, versions pinned by constraints.txt"
	@echo "make lint      ruff and mypy"
	@echo "make clean     remove .venv and caches; outputs/ stays"

setup: $(READY)

# The stamp is written last, so that an interrupted installation is repeated.
$(READY): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "Python 3.11 or newer is needed; name one: make PYTHON=python3.12"; exit 1; }
	$(PYTHON) -m venv .venv
	.venv/bin/pip install --quiet --disable-pip-version-check --no-compile -c constraints.txt -e '.[dev]'
	@echo "Compiling what was installed, on all cores; pip would take one."
	@.venv/bin/python -m compileall -qq -j 0 -x '/tests/' .venv/lib || true
	@touch $@

explore: $(READY)
	.venv/bin/curionav explore -m env=small_room agent=lbs_dreamer,random,bounce scale=cpu loop.episodes=$(EPISODES)

controls: $(READY)
	$(SWEEP) $(ROOM) $(BASELINES) hydra.sweep.dir=$(CONTROLS)/room_wanderers
	$(SWEEP) $(FLAT) $(BASELINES) hydra.sweep.dir=$(CONTROLS)/flat_wanderers
	$(SWEEP) $(ROOM) $(QUESTION) hydra.sweep.dir=$(CONTROLS)/room_learners
	$(SWEEP) $(FLAT) $(QUESTION) hydra.sweep.dir=$(CONTROLS)/flat_learners
	$(SWEEP) $(ROOM) $(QUESTION) agent.curiosity=none,count,disagreement,rnd hydra.sweep.dir=$(CONTROLS)/room_others
	.venv/bin/curionav compare $(CONTROLS)/room_* $(CONTROLS)/flat_* out=$(CONTROLS)/compare

teach: $(READY)
	$(SWEEP) $(WORLD) agent=$(call joined,$(EXPLORERS)) 'seed=range($(SEEDS))' $(COLLECT) \
		hydra.sweep.dir=$(TEACH)/collected 'hydra.sweep.subdir=$${agent.name}_$${seed}'
	.venv/bin/curionav train -m launcher=cores experiment=what_explorers_teach $(WORLD) 'seed=range($(SEEDS))' $(LEARN) \
		'data=$(COLLECTED)' hydra.sweep.dir=$(TEACH)/trained
	.venv/bin/curionav compare $(TEACH)/trained out=$(TEACH)/compare

figures: cost $(FIGURES) $(TABLES) paper-vs-ours

# Disk: about 6 kB a step. Time at scale=cpu: 6 CPU-seconds an episode of ours, 0.4 of C-BET, 2 of robot=turtlebot2i.
cost:
ifeq ($(SCALE),paper)
	@echo "SCALE=paper runs 15 x 2 M steps of ours, 45 x 5 M of the three C-BETs and 1.6 M of the robot: 256.6 M steps in"
	@echo "513 200 episodes. Disk: about 1.5 TB in $(FIG). Time, by benchmarks/RESULTS.md: 360 core-hours of C-BET,"
	@echo "56 of acting of ours, and 6.3 M updates of ours, for which that page has no GPU's time: at 0.1 s each 175 hours."
else ifeq ($(SCALE),cpu)
	@echo "SCALE=cpu is 63 runs of 100 episodes, 3.15 M steps. Disk: about 19 GB in $(FIG). Time: some three hours"
	@echo "on two cores. Any of the targets can be made alone, and Ctrl-C loses nothing but the running episode."
endif

$(RUNS)/ours/.done: EXPERIMENT = experiment=apartments agent=lbs_dreamer $(OURS)
$(RUNS)/theirs/.done: EXPERIMENT = experiment=apartments agent=cbet,cbet_ego,cbet_lifelong $(THEIRS)
$(RUNS)/small/.done: EXPERIMENT = experiment=real_small $(SMALL)
$(RUNS)/large/.done: EXPERIMENT = experiment=real_large $(LARGE)
$(RUNS)/many/.done: EXPERIMENT = experiment=comparison $(MANY)
$(RUNS)/%/.done: | $(READY)
	$(RUN) $(EXPERIMENT) hydra.sweep.dir=$(@D)
	@touch $@

figure-apartments: $(RUNS)/ours/.done $(RUNS)/theirs/.done
	$(CURIONAV) compare $(RUNS)/ours $(RUNS)/theirs out=$(FIG)/apartments

figure-small-room: $(RUNS)/small/.done
	$(CURIONAV) coverage $(RUNS)/small $(COUNT) out=$(FIG)/small_room

figure-large-lab: $(RUNS)/large/.done
	$(CURIONAV) coverage $(RUNS)/large $(COUNT) out=$(FIG)/large_lab

figure-predictions: $(RUNS)/ours/.done $(RUNS)/small/.done $(RUNS)/large/.done
	$(CURIONAV) coverage $(RUNS)/ours/0_* $(RUNS)/small/0_* $(RUNS)/large/0_* $(COUNT) out=$(FIG)/predictions

figure-best: $(RUNS)/ours/.done $(RUNS)/theirs/.done
	$(CURIONAV) compare $(RUNS)/ours $(RUNS)/theirs out=$(FIG)/best

figure-scenes: | $(READY)
	$(CURIONAV) sheet -m env=apartment_0,apartment_1,apartment_2,small_room,large_lab hydra.sweep.dir=$(FIG)/scenes

figure-docking: | $(READY)
	$(CURIONAV) paper docking out=$(FIG)/docking

table-hyperparameters: | $(READY)
	$(CURIONAV) paper hyperparameters out=$(FIG)/tables

table-sizes: | $(READY)
	$(CURIONAV) paper sizes out=$(FIG)/tables

table-docking: | $(READY)
	$(CURIONAV) dock -m env=small_room,large_lab $(DOCKING) launcher=cores hydra.sweep.dir=$(RUNS)/docking

paper-vs-ours: table-docking $(SWEEPS:%=$(RUNS)/%/.done)
	$(CURIONAV) paper numbers $(SWEEPS:%=$(RUNS)/%) $(RUNS)/docking out=$(FIG)/tables

comparison: $(RUNS)/many/.done
	$(CURIONAV) compare $(RUNS)/many baseline=random out=$(FIG)/comparison

$(LENGTH)/lab/.done: LINE = $(IN_LAB)
$(LENGTH)/lab_untrained/.done: LINE = $(IN_LAB) $(UNTRAINED)
$(LENGTH)/lab_shuffled/.done: LINE = $(IN_LAB) agent.curiosity=shuffled
$(LENGTH)/lab_seed_1/.done: LINE = $(IN_LAB) seed=1
$(LENGTH)/lab_unchanged/.done: LINE = $(IN_LAB) env.changes=false
$(LENGTH)/lab_unchanged_untrained/.done: LINE = $(IN_LAB) env.changes=false agent=bounce,mapper $(THRICE)
$(LENGTH)/lab_cbet/.done: LINE = $(IN_LAB) $(CBETS)
$(LENGTH)/apartment_0%.done: APARTMENT = env=apartment_0
$(LENGTH)/apartment_1%.done: APARTMENT = env=apartment_1
$(LENGTH)/apartment_2%.done: APARTMENT = env=apartment_2
$(LENGTH)/apartment_%/.done: LINE = $(IN_APARTMENT) $(APARTMENT)
$(LENGTH)/apartment_%_untrained/.done: LINE = $(IN_APARTMENT) $(APARTMENT) $(UNTRAINED)
$(LENGTH)/apartment_%_cbet/.done: LINE = $(IN_APARTMENT) $(APARTMENT) $(CBETS) $(FURTHER)
$(LENGTH)/room/.done: LINE = experiment=paper_length_room $(SHORT)
$(LENGTH)/%/.done: | $(READY)
	$(CURIONAV) explore -m $(strip $(LINE)) hydra.sweep.dir=$(@D)
	@touch $@

paper-length: $(LENGTHS:%=$(LENGTH)/%/.done) paper-length-figures

# Of the runs that there are, also while they go on.
paper-length-figures: | $(READY)
	$(CURIONAV) paper figures $(LENGTH)/* out=$(LENGTH)_figures
	$(CURIONAV) paper changes $(LENGTH)/lab* out=$(LENGTH)_changes

# About 3.8 MB. Time at SCALE=cpu: docs/card.md.
pretrained: $(READY)
ifeq ($(SCALE),paper)
	@echo "SCALE=paper trains an agent of 50 MB, and weeks long. Choose SCALE=cpu or SCALE=smoke." >&2; exit 2
endif
	$(RUN) $(APARTMENTS) $(SIZED) $(RECORDED) hydra.sweep.dir=$(PRETRAINED)/explored
	$(CURIONAV) train env=apartment_0 data=$(PRETRAINED)/explored $(SIZED) $(LEARNED) hydra.run.dir=$(PRETRAINED)/trained
	$(CURIONAV) evaluate -m $(PRETRAINED)/trained $(APARTMENTS) $(MEASURED) hydra.sweep.dir=$(PRETRAINED)/evaluated
	$(CURIONAV) card $(PRETRAINED)/trained $(PRETRAINED)/evaluated pretrained=$(NAME)

# Only the plugins that are used, and what is compiled is kept, so that a test's processes need not compile it again.
test: export PYTEST_DISABLE_PLUGIN_AUTOLOAD = 1
test: export PYTHONDONTWRITEBYTECODE =
test: $(READY)
	.venv/bin/python -m pytest -q -p xdist.plugin -p pytest_timeout -n $(WORKERS) --dist worksteal

docs: $(READY)
	.venv/bin/python -m documentation
	NO_MKDOCS_2_WARNING=1 .venv/bin/python -m mkdocs build --strict --quiet
	@echo "The site is site/index.html; .venv/bin/python -m http.server -d site has its search too."

# Without its dependencies: it asks for virtualenv<21, which it does not import and whose filelock is not torch's here.
TIANSHOU = tianshou sensai-utils pettingzoo deepdiff ordered-set overrides pandas pytz
clients: $(READY)
	.venv/bin/pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,clients]'
	.venv/bin/pip install --quiet --disable-pip-version-check -c constraints.txt --no-deps $(TIANSHOU)
	.venv/bin/python -m pytest -q -m 'clients and not slow' tests/clients tests/agents/sb3

# trackio needs an older pillow, so that its tests run in an environment of its own, which borrows the rest from .venv.
TRACKERS = .trackers
trackers: $(READY)
	$(PYTHON) -m venv $(TRACKERS)
	.venv/bin/python -c "import sysconfig; print('import site; site.addsitedir(%r)' % sysconfig.get_path('purelib'))" \
		> $$(echo $(TRACKERS)/lib/python3*/site-packages)/borrowed.pth
	$(TRACKERS)/bin/pip install --quiet --disable-pip-version-check -c constraints-trackio.txt trackio
	$(TRACKERS)/bin/python -m pytest -q -n 0 tests/storage/test_loggers.py tests/storage/test_trackers.py

# A real robot in ROS 2 that is not ours, in an environment of its own: these wheels run code in every Python they are in.
PEERS = .peers/venv
.peers/.ready: Makefile
	$(PYTHON) -m venv $(PEERS)
	$(PEERS)/bin/pip install --quiet --disable-pip-version-check ros-rclpy==9.1.2 ros-rmw-fastrtps-cpp ros-nav-msgs \
		ros-sensor-msgs ros-geometry-msgs ros-test-msgs rosbridge-server-rs==0.1.6 pybullet==3.2.7
	chmod +x $(PEERS)/lib/python3*/site-packages/rosbridge_server_rs/rosbridge_server_rs_*
	ln -sf librmw_fastrtps_cpp.so $(PEERS)/lib/librmw_implementation.so
	@touch $@

ros-peer: $(READY) .peers/.ready
	.venv/bin/python -m pytest -q -n 0 -m 'ros2 and not slow' tests/live

# LBS Dreamer on that robot: three episodes, docking between them. STALE, MOVE: seconds, more where the machine is busy.
STALE ?= 3
MOVE ?= 2.5
ros-explore: $(READY) .peers/.ready
	.venv/bin/python tests/peers/with_peer.py .venv/bin/curionav explore -cd tests/peers/conf env=live robot=rosbridge \
		robot/profile=peer robot.stale=$(STALE) robot.move=$(MOVE) agent=lbs_dreamer scale=cpu loop.steps=100 loop.iterations=20 loop.episodes=3

lint: $(READY)
	.venv/bin/ruff check .
	.venv/bin/mypy

clean:
	rm -rf .venv build dist site .pytest_cache .ruff_cache .mypy_cache
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +
