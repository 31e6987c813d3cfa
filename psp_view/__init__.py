"""Pictures, pages and reports of platoon runs; knows the model, and nothing of FMI."""
