"""What becomes the FMU: one table of variables, the slave, the launcher and the native runtime, the packing."""
