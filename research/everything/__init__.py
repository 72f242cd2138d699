"""`python -m research all`: every measurement that writes a page, in the order of plan.yaml."""
