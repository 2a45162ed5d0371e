#!/usr/bin/env bash
# Guess: with hydra.sweeper.max_failure_rate=1 a job that returns nan is one failed trial, and the search goes on.
# What happens: it ends with the second trial's "nan", which is told to the study a second time; a raised error does not.
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
    with open("begun.txt", "a") as file:
        file.write("a trial\n")
    if len(open("begun.txt").readlines()) == 2:
        if config.how == "raise":
            raise ArithmeticError("no number")
        return float("nan")
    return config.x

app()
APP
begun() {
    rm -f begun.txt
    venv/bin/python app.py -m "+x=interval(0,1)" "+how=$1" hydra/sweeper=optuna hydra.sweeper.n_trials=6 \
        hydra.sweeper.n_jobs=1 hydra.sweeper.max_failure_rate=1 > log.txt 2>&1 || true
    wc -l < begun.txt | tr -d ' '
}
raised=$(begun raise)
nan=$(begun nan)
venv/bin/pip list 2> /dev/null | grep -i -E '^(hydra|optuna)'
echo "Trials begun of 6, where the second raises:       $raised"
echo "Trials begun of 6, where the second returns nan:  $nan"
tail -n 3 log.txt
[ "$raised" = 6 ] && [ "$nan" = 2 ]
