"""Tests: a room for each package, in the order of the method, and rooms for what concerns all of them."""
