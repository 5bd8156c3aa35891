"""`python -m keypose.app` is `keypose`."""

from __future__ import annotations

import sys

from keypose.app.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
