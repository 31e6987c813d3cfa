"""What is computed to be looked at; draws nothing."""
