"""Many tasks on many processes or machines, stopped and taken up again."""
