"""The study of optimised against equidistant rings."""
