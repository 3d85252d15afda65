"""From the bytes of a file to polygons, one module a format; every number is the file's own.

Libraries were asked first, on the two hundred files that `tests/meshes/file_variants.py` makes. Of these trimesh reads
85 with another area and without a word, meshio 65, and each refuses more whole files than it reads rightly;
tinyobjloader reads what is cut short, and has had no release but candidates; plyfile knows neither wrapped rows nor
strips.
"""
