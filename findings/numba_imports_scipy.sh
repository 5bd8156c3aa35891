#!/usr/bin/env bash
# Numba 0.68.1 imports scipy.linalg, where SciPy is installed, when the first function of a process
# is compiled, even x + 1 of an integer: its numpy support looks for the BLAS functions there,
# whether or not anything calls them. import numba alone does not. A command that loads one
# compiled loop cannot start without SciPy's linear algebra, however late it imports that itself.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet numba==0.68.1 numpy==2.4.6 scipy==1.17.1
cd "$folder"
venv/bin/python - <<'PYTHON'
import sys

import numba

print("Numba", numba.__version__)
print("imported:", "scipy.linalg" in sys.modules)
assert "scipy.linalg" not in sys.modules, "import numba brings it already: this has changed"
assert numba.njit(lambda x: x + 1)(1) == 2
print("after one function of an integer:", "scipy.linalg" in sys.modules)
assert "scipy.linalg" in sys.modules, "it is not imported any more: this has changed"
PYTHON
