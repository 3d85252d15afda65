"""A file is read with the right area, or refused in words that fit: never with another area."""

import pytest

import meshes
from tests.meshes.file_variants import VARIANTS


@pytest.mark.parametrize("name", VARIANTS)
def test_variant(tmp_path, name):
    variant = VARIANTS[name]
    path = tmp_path / variant.name
    path.write_bytes(variant.content)
    if variant.refused is not None:
        with pytest.raises(meshes.MeshError, match=variant.refused) as caught:
            meshes.load(path)
        assert str(path) in str(caught.value)
        return
    mesh = meshes.load(path)
    assert mesh.area == pytest.approx(variant.area, rel=1e-6)
    if variant.volume is not None:
        assert mesh.volume == pytest.approx(variant.volume, rel=1e-6) and mesh.metadata["watertight"]
    notes = " ".join(mesh.metadata["notes"])
    assert (variant.note or "") in notes and bool(notes) == bool(variant.note)


def test_there_are_many():
    assert len(VARIANTS) >= 120


WHOLE = ("STL binary", "STL text, Unix", "OBJ, Unix", "OBJ, triangles", "OBJ, texture", "PLY text, Unix",
         "PLY text, triangles", "PLY little-endian", "PLY strips, binary_big_endian", "OFF, Unix")  # fmt: skip


@pytest.mark.parametrize("name", WHOLE)
def test_a_file_cut_anywhere_is_not_read_without_a_word(tmp_path, name):
    variant = VARIANTS[name]
    path = tmp_path / variant.name
    for length in (*range(0, len(variant.content) - 120, 7), *range(len(variant.content) - 120, len(variant.content))):
        path.write_bytes(variant.content[:length])
        try:
            mesh = meshes.load(path)
        except meshes.MeshError:
            continue
        # The lines of an OBJ file are not counted: one that ends with a line is whole as far as it goes.
        ended = name.startswith("OBJ") and variant.content[:length].endswith(b"\n")
        assert ended or mesh.area == pytest.approx(variant.area, rel=1e-6) or mesh.metadata["notes"], length
