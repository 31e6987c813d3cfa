"""The tables of FMI variables, and what is generated from them."""
