"""How the experiments begin and end as programs."""

from __future__ import annotations

import sys
from collections.abc import Callable


def run_program(main: Callable[[], int]) -> None:
    """Calls `main` and exits with its status; 130 after Ctrl-C, without a traceback."""
    try:
        raise SystemExit(main())
    except KeyboardInterrupt:
        print("\ninterrupted", file=sys.stderr)
        raise SystemExit(130) from None
