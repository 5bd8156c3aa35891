#!/usr/bin/env bash
# Numba 0.68.1 compiles a[:] = b between arrays to some seventeen times the code of the two loops
# that copy element by element, in some thirty times the time: the words of the error for shapes
# that differ are put together by compiled code, which brings along the formatting of text, and is
# compiled again in every function that assigns so. a[:] = 0.0 is as small as a loop.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet numba==0.68.1 numpy==2.4.6
cd "$folder"
venv/bin/python - <<'PYTHON'
import time

import numba
from numba import njit, types


def loops(a, b):
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            a[i, j] = b[i, j]


def assigned(a, b):
    a[:] = b


def cleared(a, b):
    a[:] = 0.0


matrix = types.Array(types.float64, 2, "A")
njit("void(float64[:])")(lambda a: None)  # the compiler gets ready
size = {}
for function in (loops, assigned, cleared):
    began = time.perf_counter()
    compiled = njit(function)
    compiled.compile((matrix, matrix))
    size[function] = len(compiled.inspect_llvm((matrix, matrix)))
    print(f"{function.__name__}: {size[function]} characters of LLVM, {time.perf_counter() - began:.2f} s")
print("Numba", numba.__version__)
assert size[assigned] > 8 * size[loops], "an assignment is small now: this has changed"
assert size[cleared] < 2 * size[loops], size
PYTHON
