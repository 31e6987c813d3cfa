"""The C compiler from PyPI, serving the two runtimes."""
