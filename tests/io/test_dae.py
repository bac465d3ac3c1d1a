import numpy as np
import pytest
from numpy.testing import assert_allclose
from solids import Box, volume

from graft import InputError, load_object
from graft.io.mesh_file import read_mesh

BOX = Box(size=(60, 60, 100))


def collada(primitive=None, nodes=None, unit="0.001", up="Z_UP", positions=None):
    points = " ".join(map(str, BOX.vertices.ravel())) if positions is None else positions
    corners = " ".join(f"{i} 0" for quad in BOX.quads for i in quad)
    primitive = primitive or f"<polylist INPUTS><vcount>4 4 4 4 4 4</vcount><p>{corners}</p></polylist>"
    head, _, rest = primitive.partition(" INPUTS>")
    primitive = (
        f'{head} count="6"><input semantic="VERTEX" source="#v" offset="0"/>'
        f'<input semantic="NORMAL" source="#n" offset="1"/>{rest}'
    )
    nodes = nodes or '<node name="cup"><instance_geometry url="#g"/></node>'
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
 <asset><unit meter="{unit}"/><up_axis>{up}</up_axis></asset>
 <library_geometries><geometry id="g" name="shell"><mesh>
  <source id="p"><float_array id="a" count="24">{points}</float_array>
   <technique_common><accessor source="#a" count="8" stride="3"/></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
  {primitive}
 </mesh></geometry></library_geometries>
 <library_visual_scenes><visual_scene id="s">{nodes}</visual_scene></library_visual_scenes>
 <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>"""


TRIANGLES = "<triangles INPUTS><p>" + " ".join(f"{i} 0" for i in BOX.faces.ravel()) + "</p></triangles>"
POLYGONS = (
    "<polygons INPUTS>"
    + "".join("<p>" + " ".join(f"{i} 0" for i in quad) + "</p>" for quad in BOX.quads)
    + "</polygons>"
)


@pytest.mark.parametrize("primitive", [None, TRIANGLES, POLYGONS])
def test_every_primitive_in_metres(tmp_path, primitive):
    (tmp_path / "cup.dae").write_text(collada(primitive))
    obj = load_object(tmp_path / "cup.dae")
    assert obj.part_names == ("cup",)
    assert obj.scale_to_metres == 1.0
    assert obj.up.tolist() == [0, 0, 1]
    assert_allclose(obj.bounds[1], [0.06, 0.06, 0.1])
    assert volume(obj.parts[0]) == pytest.approx(0.06 * 0.06 * 0.1)


def test_the_up_axis_is_told_and_not_applied(tmp_path):
    (tmp_path / "cup.dae").write_text(collada(up="Y_UP"))
    obj = load_object(tmp_path / "cup.dae")
    assert obj.up.tolist() == [0, 1, 0]
    assert_allclose(obj.bounds[1], [0.06, 0.06, 0.1])


def test_nodes_are_parts_with_their_transforms(tmp_path):
    nodes = """<node name="both"><translate>0 0 50</translate><rotate>0 0 1 90</rotate>
      <node name="left"><instance_geometry url="#g"/></node>
      <node name="right"><scale>-1 1 1</scale><instance_geometry url="#g"/></node></node>"""
    (tmp_path / "cup.dae").write_text(collada(nodes=nodes))
    left, right = read_mesh(tmp_path / "cup.dae")
    assert (left.name, right.name) == ("left", "right")
    assert_allclose(left.vertices.min(axis=0), [-0.06, 0, 0.05], atol=1e-12)
    assert_allclose(right.vertices.min(axis=0), [-0.06, -0.06, 0.05], atol=1e-12)
    assert volume(left) == pytest.approx(volume(right))  # a mirror does not turn it inside out


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("<robot/>", r"expected <COLLADA>, got <robot>"),
        (collada()[:400], r"not well-formed"),
        (collada(unit="0"), r"unit of 0.0 metres"),
        (collada(unit="x"), r"malformed"),
        (collada(up="W_UP"), r"up axis 'W_UP'"),
        (collada(positions="0 0 one"), r"line 5: <float_array>"),
        (collada(positions="0 0"), r"line 5: 2 numbers are no positions"),
        (collada(positions="0 0 0"), r"'cup' face 0: vertex index out of range"),
        (collada(TRIANGLES.replace(">0 0 ", ">0 0 0 ", 1)), r"indices for 2 inputs"),
        (collada("<polylist INPUTS><vcount>4</vcount><p>0 0 1 0</p></polylist>"), r"vcount says 4 corners"),
        (collada(nodes="<node/>"), r"no node of the scene holds"),
        (collada(nodes='<node><instance_geometry url="http://x"/></node>'), r"expected the id of an element"),
        (collada(nodes="<node><rotate>0 0 0 1</rotate></node>"), r"<rotate>: expected an axis"),
        (collada(nodes="<node><matrix>1 2 3</matrix></node>"), r"<matrix>: expected 16 numbers, got 3"),
        (collada(nodes='<node id="n"><instance_node url="#n"/></node>'), r"in a circle"),
        (
            collada(
                nodes="".join(
                    f'<node id="n{i}"><instance_node url="#n{i + 1}"/><instance_node url="#n{i + 1}"/></node>'
                    for i in range(60)
                )
                + '<node id="n60"/>'
            ),
            r"too deep, or in a circle",
        ),
        (collada().replace("?>", '?><!DOCTYPE a [<!ENTITY b "c">]>', 1), r"DOCTYPE"),
    ],
)
def test_bad_collada(tmp_path, text, match):
    (tmp_path / "cup.dae").write_text(text)
    with pytest.raises(InputError, match=match) as caught:
        load_object(tmp_path / "cup.dae")
    assert "cup.dae" in str(caught.value)


def test_corners_are_read_at_their_offset(tmp_path):
    corners = " ".join(f"7 {i}" for i in BOX.faces.ravel())
    text = collada(f"<triangles INPUTS><p>{corners}</p></triangles>")
    text = text.replace('source="#v" offset="0"', 'source="#v" offset="1"')
    text = text.replace('source="#n" offset="1"', 'source="#n" offset="0"')
    (tmp_path / "cup.dae").write_text(text)
    [piece] = read_mesh(tmp_path / "cup.dae")
    assert np.array_equal(piece.faces, BOX.faces)
