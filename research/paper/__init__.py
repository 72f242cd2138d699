"""Every table and figure of the GzDRL paper, with its measurement here and whether it holds."""
