"""The laws: potential, the paper's feedback, and its extension for platoons on a road."""
