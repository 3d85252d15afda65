"""The results of the paper: the quick run, the committed ones, fits."""
