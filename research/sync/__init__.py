"""How synchronous the steps of a policy are: in one process, and through middleware."""
