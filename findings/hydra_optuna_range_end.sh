#!/usr/bin/env bash
# Guess: `x=range(0,3)` means 0, 1, 2 to hydra-optuna-sweeper too, whatever its sampler, as it does to Hydra.
# What happens: the random sampler draws 3 as well; the grid sampler of the same sweeper never does.
# hydra-optuna-sweeper 1.3.0 (optuna 2.10.1) with hydra-core 1.3.8, Python 3.11, 2026-11-29.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install -q --disable-pip-version-check hydra-core==1.3.8 hydra-optuna-sweeper==1.3.0 optuna==2.10.1 \
    sqlalchemy==1.4.54 alembic==1.16.5 2> /dev/null
cat > app.py << 'APP'
import hydra

@hydra.main(version_base="1.3", config_path=None)
def app(config):
    with open("drawn.txt", "a") as file:
        file.write(f"{config.x}\n")
    return float(config.x)

app()
APP
drawn() {
    rm -f drawn.txt
    venv/bin/python app.py -m "+x=range(0,3)" "$@" > log.txt 2>&1 || { cat log.txt >&2; return 1; }
    sort -u drawn.txt | paste -s -d ' '
}
optuna="hydra/sweeper=optuna hydra.sweeper.n_trials=40"
basic=$(drawn)
grid=$(drawn $optuna hydra/sweeper/sampler=grid)
random=$(drawn $optuna hydra/sweeper/sampler=random hydra.sweeper.sampler.seed=1)
venv/bin/pip list 2> /dev/null | grep -i -E '^(hydra|optuna)'
echo "x=range(0,3)"
echo "  Hydra's own sweeper: $basic"
echo "  optuna, grid:        $grid"
echo "  optuna, random:      $random"
[ "$basic" = "0 1 2" ] && [ "$grid" = "0 1 2" ] && [ "$random" = "0 1 2 3" ]
