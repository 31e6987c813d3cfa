"""What is controlled: vehicles, and a leader with a speed of his own."""
