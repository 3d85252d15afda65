"""In what condition a mesh is: what is mended without being asked, what a repair puts right, what cannot be used."""
