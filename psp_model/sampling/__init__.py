"""Zero-order hold, the sampling clock, Lemma 1, and the pure step of the closed loop."""
