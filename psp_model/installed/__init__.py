"""What is installed: the project's files that are no Python, and the packages that its extras bring."""
