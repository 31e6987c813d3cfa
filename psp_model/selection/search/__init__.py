"""The global search for the best alpha, r, p, and the engine of its rollouts."""
