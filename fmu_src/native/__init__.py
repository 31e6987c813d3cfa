"""The native FMU: C generated from the model by CasADi, behind the FMI front that all FMUs share."""
