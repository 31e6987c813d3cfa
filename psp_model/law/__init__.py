"""The feedback law: potential and feedback."""
