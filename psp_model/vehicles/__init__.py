"""Plants: vehicles, and leaders with a given speed."""
