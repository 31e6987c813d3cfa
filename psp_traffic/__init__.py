"""The controller FMU in traffic simulated by SUMO, compared with SUMO's own drivers."""
