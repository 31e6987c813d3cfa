"""The explorer: a page with sliders in front of the model."""
