#!/usr/bin/env bash
# Guess: Hydra passes over an installed plugin that cannot be imported, with a warning, when an app does not use it.
# What happens: so it does where a package is missing; hydra-rq-launcher on Python 3.11 raises ValueError and ends the app.
# hydra-rq-launcher 1.2.0 with hydra-core 1.3.8, Python 3.11 (its dataclasses refuse mutable defaults), 2026-11-29.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install -q --disable-pip-version-check hydra-core==1.3.8 2> /dev/null
cat > app.py << 'APP'
import hydra

@hydra.main(version_base="1.3", config_path=None)
def app(config):
    print("the app ran")

app()
APP
ran() {
    if venv/bin/python app.py > log.txt 2>&1; then echo yes; else echo no; fi
}
site=$(venv/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
mkdir -p "$site/hydra_plugins/misses_a_package"
echo 'import a_package_that_is_not_there' > "$site/hydra_plugins/misses_a_package/__init__.py"
missing=$(ran)
rm -r "$site/hydra_plugins/misses_a_package"
venv/bin/pip install -q --disable-pip-version-check hydra-rq-launcher==1.2.0 2> /dev/null
launcher=$(ran)
venv/bin/python --version
venv/bin/pip list 2> /dev/null | grep -i '^hydra'
echo "The app runs beside a plugin that misses a package: $missing"
echo "The app runs beside hydra-rq-launcher:              $launcher"
tail -n 1 log.txt
[ "$missing" = yes ] && [ "$launcher" = no ]
