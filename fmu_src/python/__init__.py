"""The Python FMUs: slaves, launcher, and how they are built."""
