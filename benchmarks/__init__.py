"""What the project costs beside its floors and its peers: `python -m benchmarks`, or `make bench`."""
