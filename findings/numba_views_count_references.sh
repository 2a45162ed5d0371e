#!/usr/bin/env bash
# Guess: in a compiled numba function a row of an array, a[k], is a pointer and costs nothing.
# Found: a helper that is given rows runs several times as long as the same helper given whole arrays and an index: each
# view counts references with atomic instructions. numba 0.68.1, numpy 2.4.6, x86_64; 2026-11-30.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check numba==0.68.1 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import time

import numba
import numpy as np
from numba import njit


@njit
def of_rows(a, b, c, d, e):
    return a[0] * b[1] + c[2] * d[3] + e[0]


@njit
def by_rows(a, b, c, d, e):
    total = 0.0
    for k in range(len(a)):
        total += of_rows(a[k], b[k], c[k], d[k], e[k])
        e[k] = a[k]
    return total


@njit
def of_arrays(a, b, c, d, e, k):
    return a[k, 0] * b[k, 1] + c[k, 2] * d[k, 3] + e[k, 0]


@njit
def by_index(a, b, c, d, e):
    total = 0.0
    for k in range(len(a)):
        total += of_arrays(a, b, c, d, e, k)
        for i in range(4):
            e[k, i] = a[k, i]
    return total


def least(function, arrays):
    taken = []
    for _ in range(10):
        began = time.process_time()
        function(*arrays)
        taken.append(time.process_time() - began)
    return min(taken[1:])


arrays = [np.random.default_rng(seed).random((300_000, 4)) for seed in range(5)]
ratio = least(by_rows, arrays) / least(by_index, arrays)
print(f"numba {numba.__version__}: with rows it takes {ratio:.1f} times as long as with indices")
assert ratio > 2, "views are free now"
PYTHON
