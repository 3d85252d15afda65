"""Pieces of faces in the faces' own coordinates: cut, asked about, united."""
