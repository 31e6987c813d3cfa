"""Which potential a platoon runs with."""
