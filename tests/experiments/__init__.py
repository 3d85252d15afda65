"""What a person runs, room by room as in `experiments`."""
