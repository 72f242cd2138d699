"""Flight logs from the logs of real flights: `skybody import`; docs/imports.md."""
