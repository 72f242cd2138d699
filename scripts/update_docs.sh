#!/usr/bin/env bash
# Updates generated documentation:
# - docs/scenarios.md from its head and the declared keys,
# - docs/plugin_reference.md from the headers,
# - tables and figure of docs/control-modes.md from the built plugins,
# - the tables of options in docs/python.md and of hyper-parameters in docs/training.md from the
#   Python package,
# - the tables of observations and infos in the READMEs of tasks from their declarations,
# - the tables of learning results from docs/results/data.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
{ cat scripts/scenarios_head.md; build/release/bin/skybody schema --markdown; } >docs/scenarios.md
python3 scripts/plugin_reference.py
python3 scripts/control_page.py
PYTHONPATH=python .venv/bin/python scripts/python_options.py
PYTHONPATH=python .venv/bin/python scripts/hyperparameters.py
PYTHONPATH=python .venv/bin/python scripts/task_tables.py
PYTHONPATH=python .venv/bin/python experiments/learned_tables.py
