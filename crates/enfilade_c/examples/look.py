"""Python by ctypes: a wall and a thousand boxes, which of them are visible, and a picture. Uses numpy if it is there.

Run: python3 look.py PREFIX/lib/libenfilade_c.so
"""

import ctypes as c
import sys

try:
    import numpy
except ImportError:
    numpy = None

VERSION = 100


class Error(c.Structure):
    _fields_ = [("status", c.c_uint32), ("reserved", c.c_uint32), ("index", c.c_uint64), ("code", c.c_char * 48), ("message", c.c_char * 448)]


class MeshPart(c.Structure):
    _fields_ = [("positions", c.c_void_p), ("position_count", c.c_size_t), ("position_stride", c.c_size_t), ("indices", c.c_void_p), ("index_count", c.c_size_t), ("index_size", c.c_uint32), ("material", c.c_uint32)]


class Material(c.Structure):
    _fields_ = [("color", c.c_float * 4), ("alpha", c.c_uint32), ("double_sided", c.c_uint32), ("detail", c.c_uint32)]


class ItemOptions(c.Structure):
    _fields_ = [("flags", c.c_uint32), ("layers", c.c_uint32), ("max_distance", c.c_float), ("min_size_px", c.c_float)]


class Item(c.Structure):
    _fields_ = [("mesh", c.c_void_p), ("key", c.c_uint64), ("sector_from_item", c.c_float * 16), ("options", ItemOptions), ("name", c.c_char_p)]


class Camera(c.Structure):
    _fields_ = [("eye", c.c_double * 3), ("target", c.c_double * 3), ("up", c.c_double * 3), ("fov_y", c.c_float), ("near_distance", c.c_float), ("parallel_height", c.c_float), ("reserved", c.c_uint32), ("sector", c.c_uint64), ("name", c.c_char * 64)]


class View(c.Structure):
    _fields_ = [("eye_from_sector", c.c_double * 16), ("clip_from_eye", c.c_double * 16), ("sector", c.c_uint64), ("clip_depth", c.c_uint32), ("left", c.c_uint32), ("top", c.c_uint32), ("width", c.c_uint32), ("height", c.c_uint32), ("reserved", c.c_uint32)]


class Enfilade:
    """Calls functions by their names without `enfilade_`, and raises what they refuse."""

    def __init__(self, path):
        self.library = c.CDLL(path)

    def __getattr__(self, name):
        function = getattr(self.library, "enfilade_" + name)

        def call(*arguments):
            error = Error()
            if function(*arguments, c.byref(error)) != 0:
                raise ValueError(f"{error.code.decode()}: {error.message.decode()} (element {error.index})")

        return call

    def create(self, kind, *arguments):
        handle = c.c_void_p()
        getattr(self, kind)(VERSION, *arguments, c.byref(handle))
        return handle


def bytes_of(kind, numbers):
    """Returns numbers as an array that C reads, and that must be kept meanwhile."""
    if numpy is not None:
        array = numpy.ascontiguousarray(numbers, dtype=kind)
        return array, array.ctypes.data
    array = ({"f4": c.c_float, "u2": c.c_uint16}[kind] * len(numbers))(*numbers)
    return array, c.addressof(array)


def main():
    enfilade = Enfilade(sys.argv[1])
    corners = [value for i in range(8) for value in (0.5 if i & 1 else -0.5, 0.5 if i & 2 else -0.5, 0.5 if i & 4 else -0.5)]
    triangles = [0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6]
    kept_corners, positions = bytes_of("f4", corners)
    kept_triangles, indices = bytes_of("u2", triangles)
    part = MeshPart(positions, 8, 0, indices, 36, 2, 0)
    cube = enfilade.create("mesh_create", c.byref(part), c.c_size_t(1))
    scene = enfilade.create("scene_create")
    materials = (Material * 1)(Material((c.c_float * 4)(0.8, 0.5, 0.3, 1), 0, 0, 0))
    sector = c.c_uint64()
    enfilade.scene_add_sector(scene, b"yard", 0, materials, c.c_size_t(1), c.byref(sector))

    def item(key, at, size):
        x, y, z = at
        a, b, d = size
        return Item(cube, key, (c.c_float * 16)(a, 0, 0, 0, 0, b, 0, 0, 0, 0, d, 0, x, y, z, 1), ItemOptions(), None)

    items = [item(0, (0, 0, -5), (3, 6, 1))]
    items += [item(key, (key % 40 - 20, 0, -10 - key // 40), (0.5, 0.5, 0.5)) for key in range(1, 1001)]
    ids = (c.c_uint64 * len(items))()
    enfilade.scene_add_items(scene, sector, (Item * len(items))(*items), c.c_size_t(len(items)), ids)

    viewer = enfilade.create("viewer_create", None)
    view = View()
    enfilade.view_from_camera(c.byref(Camera(target=(0, 0, -1))), 320, 200, c.byref(view))
    enfilade.viewer_look(viewer, scene, c.byref(view), None)
    words = (c.c_uint64 * 16)()
    enfilade.viewer_bits(viewer, words, c.c_size_t(16))
    if numpy is not None:
        bits = numpy.unpackbits(numpy.frombuffer(words, dtype="u1"), bitorder="little")
        visible = numpy.flatnonzero(bits).tolist()
    else:
        visible = [key for key in range(1024) if words[key // 64] >> key % 64 & 1]
    assert visible[0] == 0 and 1 < len(visible) < 900, visible

    rgba = (c.c_uint8 * (320 * 200 * 4))()
    enfilade.viewer_draw(viewer, scene, c.byref(view), None, rgba, c.c_size_t(0), c.c_size_t(len(rgba)))
    assert all(rgba[i] == 255 for i in range(3, len(rgba), 4))

    try:
        enfilade.scene_remove_items(scene, (c.c_uint64 * 2)(ids[1], 12345), c.c_size_t(2))
        raise AssertionError("an id that never was is refused")
    except ValueError as why:
        assert "c/no-such-id" in str(why) and "element 1" in str(why), why
    for kind, handle in (("viewer", viewer), ("scene", scene), ("mesh", cube)):
        assert getattr(enfilade.library, f"enfilade_{kind}_free")(handle) == 0
    print(f"{len(visible)} of {len(items)} items are visible, {'with' if numpy else 'without'} numpy")


main()
