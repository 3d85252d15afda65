"""Layout files: where cameras sit and what they were found for, written and read back."""
