#!/usr/bin/env bash
# grimp 3.20, the graph under import-linter: its cache notes the times of files once for all options,
# and imports by option. A build with another `exclude_type_checking_imports` after an edit makes the
# cached imports of the first look current. Seen: an import that is gone is reported; without the
# cache it is not. Between such builds remove the cache (`.import_linter_cache`), or pass
# `cache_dir=None`.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3.11 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet grimp==3.20
mkdir "$folder/pair"
cd "$folder"
venv/bin/python - <<'PYTHON'
import os
from importlib.metadata import version
from pathlib import Path

import grimp


def imported(types_excluded, cache_dir):
    """What pair.first imports."""
    graph = grimp.build_graph(
        "pair", exclude_type_checking_imports=types_excluded, cache_dir=cache_dir
    )
    return graph.find_modules_directly_imported_by("pair.first")


first = Path("pair/first.py")
for name in ("__init__", "second"):
    Path(f"pair/{name}.py").write_text("")
first.write_text("import pair.second")
before = imported(False, "cache")
first.write_text("")
os.utime(first, (1, 1))  # another time than before
imported(True, "cache")
stale, fresh = imported(False, "cache"), imported(False, None)
print("grimp", version("grimp"), before, stale, fresh)
assert (before, stale, fresh) == ({"pair.second"}, {"pair.second"}, set())
PYTHON
