#!/usr/bin/env bash
# Guess: hydra.sweeper.list_params.x='[1,2],[3,4]' makes two jobs, each with a list, as x=[1,2],[3,4] does in Hydra.
# What happens: brackets are cut out of the text before it is split, so there are four jobs with a number each.
# hydra-list-sweeper 1.1.0 with hydra-core 1.3.8, Python 3.11, 2026-11-29.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install -q --disable-pip-version-check hydra-core==1.3.8 hydra-list-sweeper==1.1.0 2> /dev/null
cat > app.py << 'APP'
import hydra

@hydra.main(version_base="1.3", config_path=".", config_name="config")
def app(config):
    with open("seen.txt", "a") as file:
        file.write(f"{config.x}\n")

app()
APP
echo "x: null" > config.yaml
seen() {
    rm -f seen.txt
    venv/bin/python app.py -m "$@" > log.txt 2>&1 || { cat log.txt >&2; return 1; }
    paste -s -d ';' seen.txt
}
basic=$(seen 'x=[1,2],[3,4]')
listed=$(seen hydra/sweeper=list "+hydra.sweeper.list_params.x='[1,2],[3,4]'")
venv/bin/pip list 2> /dev/null | grep -i '^hydra'
echo "Hydra's own sweeper, x=[1,2],[3,4]:        $basic"
echo "list sweeper, list_params.x=[1,2],[3,4]:   $listed"
[ "$basic" = "[1, 2];[3, 4]" ] && [ "$listed" = "1;2;3;4" ]
