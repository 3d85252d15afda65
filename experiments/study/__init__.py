"""Optimised against equidistant rings on the sites of Wachter 2021."""
