"""Archives, system structures, and files for other tools."""
