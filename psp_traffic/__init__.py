"""The controller FMU in traffic that SUMO simulates, beside SUMO's own drivers."""
