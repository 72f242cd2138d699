#!/usr/bin/env bash
# Updates generated documentation:
# - docs/scenarios.md from its head and the declared keys,
# - docs/plugin_reference.md from the headers,
# - tables and figure of docs/control-modes.md from the built plugins,
# - the tables of options in docs/python.md and of hyper-parameters in docs/training.md from the
#   Python package,
# - the tables of observations and infos in the READMEs of tasks from their declarations,
# - the table of scenarios/README.md from the scenarios' heads,
# - the tables of learning results from docs/results/data,
# - docs/results/paper.md from docs/results/data,
# - the index of docs/results/README.md from the measurements.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
{ cat scripts/scenarios_head.md; build/release/bin/skybody schema --markdown; } >docs/scenarios.md
python3 scripts/plugin_reference.py
PYTHONPATH=python .venv/bin/python -m research run control_page
PYTHONPATH=python .venv/bin/python scripts/python_options.py
PYTHONPATH=python .venv/bin/python -m research run scenario_index
PYTHONPATH=python .venv/bin/python -m research run hyperparameters
PYTHONPATH=python .venv/bin/python -m research run task_tables
PYTHONPATH=python .venv/bin/python -m research run learned_tables
PYTHONPATH=python .venv/bin/python -m research paper --page
python3 -m research index
