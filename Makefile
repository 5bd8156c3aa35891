# run · quick · test · check · bench · clean: the commands of README and CI, nothing else.
# Another interpreter:  make run PYTHON=python3.12

PYTHON ?= python3
KEYPOSE = .venv/bin/keypose
NODE_TOOLS = tests/page/node_modules
# The page's scripts and their tests, but what others wrote, and what is written from the orders.
SCRIPTS = 'static/**/*.js' 'tests/page/*.js' '!static/vendor/**' '!static/store/orders.js'

.PHONY: run quick test browser loops check check-types check-rest check-python bench clean
.DEFAULT_GOAL := run

# Open the page, which offers the samples; copies of them, and everything else, are kept in out/.
run: .venv/.ready
	@$(KEYPOSE) open --workspace out

# In less than a minute: the checks that take seconds, and the tests nearest to what has changed.
quick: .venv/.ready-dev build/names check-python
	@.venv/bin/python -m tests.quick

test: browser
	@$(MAKE) --silent --no-print-directory --jobs=2 check loops
	@.venv/bin/pytest -n auto --dist loadfile

# A Chromium for the tests of the page, without windows where apt has one: installed where that is
# allowed. With none they are skipped.
browser: .venv/.ready-dev
	@if ! command -v chromium-headless-shell > /dev/null && \
	    [ "$$(id -u)" = 0 ] && command -v apt-get > /dev/null; then \
	    echo "Installing Chromium for the tests of the page …"; \
	    apt="apt-get --quiet=2 -o DPkg::Lock::Timeout=60"; \
	    install="$$apt install --yes --no-install-recommends"; \
	    $$apt update > /dev/null 2>&1; \
	    $$install chromium-headless-shell > /dev/null 2>&1 || \
	        .venv/bin/python -m tests.browser.chromium || $$install chromium > /dev/null || true; \
	fi
	@.venv/bin/python -m tests.browser.chromium || \
	    echo "There is no Chromium: the tests of the page will be skipped."

# The compiled loops, beside the checks, which leave a core free: or every worker compiled them.
loops: .venv/.ready-dev
	@.venv/bin/python -c 'from keypose.tracker import warm; \
	    warm.warm_all(); warm.are_hulls_warm() or warm.warm_hulls()'

check: .venv/.ready-dev build/names
	@$(MAKE) --silent --no-print-directory --jobs=2 check-types check-rest

check-types:
	@.venv/bin/mypy --no-error-summary

check-python: .venv/.ready-dev
	@.venv/bin/ruff check --quiet .
	@.venv/bin/ruff format --check --quiet .
	@.venv/bin/lint-imports --no-logo

check-rest: check-python
	@if node -e 'process.exit(parseInt(process.version.slice(1)) < 18 ? 1 : 0)' 2> /dev/null && command -v npm > /dev/null; then \
	    $(MAKE) --silent --no-print-directory $(NODE_TOOLS)/.ready && \
	    $(NODE_TOOLS)/.bin/eslint --config tests/page/eslint.config.js --max-warnings 0 static tests/page && \
	    $(NODE_TOOLS)/.bin/prettier --config tests/page/prettier.json --log-level warn --check $(SCRIPTS) && \
	    $(NODE_TOOLS)/.bin/tsc --project tests/page && \
	    $(NODE_TOOLS)/.bin/tsc --project tests/page/tsconfig.strict.json; \
	else \
	    echo "There is no Node 18 or newer with npm: eslint, prettier and tsc are skipped."; \
	fi

bench: .venv/.ready-dev
	@.venv/bin/python -m bench

# What the commands above have made; the compiled loops in ~/.cache/keypose stay.
clean:
	rm -rf .venv out build dist $(NODE_TOOLS) *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis \
	    .import_linter_cache benchmarks.json
	find app bench tracker tests sample_videos -name __pycache__ -prune -exec rm -rf {} +

# What checks the page's JavaScript; the page itself is served as it is written.
$(NODE_TOOLS)/.ready: tests/page/package.json tests/page/package-lock.json
	@echo "Installing eslint, prettier and tsc into $(NODE_TOOLS) …"
	@npm ci --prefix tests/page --ignore-scripts --loglevel=error > /dev/null
	@touch $@

# mypy does not ask the installed package map where `keypose` is: links that say it.
build/names:
	@mkdir -p $@/keypose
	@for name in app sample_videos static tracker; do ln -sfn ../../../$$name $@/keypose/$$name; done

.venv/.ready: pyproject.toml | .venv/bin/pip
	@echo "Installing Keypose and what it needs into .venv …"
	@.venv/bin/pip install --quiet --disable-pip-version-check --editable .
	@touch $@

.venv/.ready-dev: pyproject.toml | .venv/bin/pip
	@echo "Installing Keypose, what it needs and what its tests need into .venv …"
	@.venv/bin/pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@ .venv/.ready

.venv/bin/pip:
	@command -v $(PYTHON) > /dev/null || { \
	    echo "Keypose needs Python 3.11 or newer, but there is no $(PYTHON); name one with: make PYTHON=…" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	    echo "Keypose needs Python 3.11 or newer, but $(PYTHON) is older; name another one with: make PYTHON=…" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2> /dev/null || { \
	    echo "$(PYTHON) cannot make virtual environments; on Debian and Ubuntu this helps: apt-get install python3-venv" >&2; exit 1; }
	@$(PYTHON) -m venv .venv
