// Enfilade: frustum, portal and occlusion culling on the CPU, for any engine.
//
// Give it a scene and a camera; each frame it returns the visible objects. It never culls a visible one, at a stated precision.
//
//     #include "enfilade.h"
//     #include <stdio.h>
//     static EnfiladeError error;
//     #define TRY(call) if ((call) != ENFILADE_STATUS_OK) return fprintf(stderr, "%s: %s\n", error.code, error.message), 1
//     int main(void) {
//         const float square[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
//         const uint16_t triangles[] = {0, 1, 2, 0, 2, 3};
//         const EnfiladeMeshPart part = {.positions = square, .position_count = 4, .indices = triangles, .index_count = 6, .index_size = 2};
//         const EnfiladeMaterial grey = {.color = {0.6f, 0.6f, 0.6f, 1.0f}};
//         const EnfiladeCamera camera = {.target = {0, 0, -1}};
//         EnfiladeMesh *mesh; EnfiladeScene *scene; EnfiladeViewer *viewer;
//         EnfiladeSectorId room; EnfiladeItemId ids[2]; EnfiladeView view; uint64_t bits;
//         TRY(enfilade_mesh_create(ENFILADE_VERSION, &part, 1, &mesh, &error));
//         TRY(enfilade_scene_create(ENFILADE_VERSION, &scene, &error));
//         TRY(enfilade_scene_add_sector(scene, "room", ENFILADE_METHOD_MASKED, &grey, 1, &room, &error));
//         const EnfiladeItem items[] = { // 4 and 9 units ahead: the first hides the second
//             {.mesh = mesh, .key = 0, .sector_from_item = {1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, -4, 1}},
//             {.mesh = mesh, .key = 1, .sector_from_item = {1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, -9, 1}}};
//         TRY(enfilade_scene_add_items(scene, room, items, 2, ids, &error));
//         TRY(enfilade_viewer_create(ENFILADE_VERSION, NULL, &viewer, &error));
//         TRY(enfilade_view_from_camera(&camera, 1280, 720, &view, &error));
//         TRY(enfilade_viewer_look(viewer, scene, &view, NULL, &error)); // each frame
//         TRY(enfilade_viewer_bits(viewer, &bits, 1, &error));
//         for (int key = 0; key < 2; key++) printf("item %d is %s\n", key, bits >> key & 1 ? "visible" : "hidden");
//         return enfilade_viewer_free(viewer) | enfilade_scene_free(scene) | enfilade_mesh_free(mesh);
//     }
//
// It prints "item 0 is visible" and "item 1 is hidden". Compile: cc first.c $(pkg-config --cflags --libs enfilade)
//
// CALLS. Every function but enfilade_version returns an EnfiladeStatus, and takes, last, an EnfiladeError of the caller that
// receives the message, the code of the broken rule and the index of what was refused; it may be null. A call that fails leaves
// results 0 and objects unchanged, unless it says otherwise. Null, NaN, ids and handles that were removed or freed, short strides
// and impossible counts are refused with a code. What cannot be detected: a pointer that is not null and points to too little, or
// to nothing.
//
// OBJECTS. A handle, such as an EnfiladeScene *, names an object until you free it. It is a number in the shape of a pointer: do not
// follow it. Handles are checked, also after they were freed; they are not used twice. Ids (uint64_t) name items, sectors, portals,
// rooms and doors of one object; 0 is none, and an id of something that was removed never names anything else.
//
// ARRAYS are read during the call and never kept, unless it says otherwise. A stride of 0 means that elements follow each other.
// Where results go to an array, `capacity` is its length and `count` receives the number of results: pass a null array to ask for it.
//
// STRUCTS. Set all of a struct to 0 first ({0}): that is a good default for options, and what future versions expect of fields that
// you do not know. Flags of a type are combined with |.
//
// UNITS AND SPACES. Lengths are in scene units, angles in radians, screens in pixels with x right and y down from the top left
// corner. Any up axis and handedness: a face is seen from where (b - a) x (c - a) points, computed from the numbers. Transforms are
// 4x4 matrices of 16 numbers, column after column, that multiply column vectors; coordinates reach up to 1e18.
//
// THREADS. The library starts none, unless you ask with enfilade_set_threads. Calls that take a const handle may run on any number of
// threads at once. A call that takes another handle must be the only one that uses this object; else ENFILADE_STATUS_BUSY is returned,
// and nothing is done. So many viewers may look at one scene at once, while nobody edits it. The order of calls is yours to keep.
//
// VERSIONS. Functions that create an object take ENFILADE_VERSION, and return ENFILADE_STATUS_WRONG_VERSION if the library is of
// another version than this header.
//
// FAULTS. No panic or exception crosses the border: a call that finds a fault in the library returns ENFILADE_STATUS_PANIC, and an
// object that it was changing returns ENFILADE_STATUS_UNUSABLE from then on; free it. Running out of memory ends the process.

#ifndef ENFILADE_H
#define ENFILADE_H

// Written by `cargo xtask header` from the crate enfilade_c. Do not edit.

#include <stddef.h>
#include <stdint.h>

/// Version of this header: 10000 x major + 100 x minor + patch. Functions that create an object take it, and compare it with
/// the library's.
#define ENFILADE_VERSION 100

/// Value of `index` in an EnfiladeError that is about no element of an array.
#define ENFILADE_NO_INDEX UINT64_MAX

/// Outcome of a call. Each function returns one, and leaves its results 0 and the objects unchanged unless it says otherwise.
enum EnfiladeStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// The call succeeded.
    ENFILADE_STATUS_OK = 0,
    /// A pointer is null that must not be.
    ENFILADE_STATUS_NULL_ARGUMENT = 1,
    /// A handle names no object of its type: it was freed, or never was one.
    ENFILADE_STATUS_BAD_HANDLE = 2,
    /// An id names nothing: it was removed, or is of another object.
    ENFILADE_STATUS_NO_SUCH_ID = 3,
    /// A number, a count, a stride, a flag or a text is invalid.
    ENFILADE_STATUS_BAD_ARGUMENT = 4,
    /// Positions or indices of a mesh or an outline break a rule.
    ENFILADE_STATUS_BAD_MESH = 5,
    /// A matrix, a camera or a viewport breaks a rule.
    ENFILADE_STATUS_BAD_VIEW = 6,
    /// A portal, a method or a room breaks a rule of scenes.
    ENFILADE_STATUS_BAD_SCENE = 7,
    /// A file cannot be read, or breaks a rule of its format.
    ENFILADE_STATUS_BAD_FILE = 8,
    /// More memory would be needed than the limit.
    ENFILADE_STATUS_TOO_LARGE = 9,
    /// The array for results is too short. It holds as many as it has room for, and the count is that of all.
    ENFILADE_STATUS_BUFFER_TOO_SMALL = 10,
    /// The header that the caller was compiled with is not that of the library.
    ENFILADE_STATUS_WRONG_VERSION = 11,
    /// Another thread is using the object, and a call that changes an object must be alone.
    ENFILADE_STATUS_BUSY = 12,
    /// An earlier call on this object returned ENFILADE_STATUS_PANIC. It can only be freed.
    ENFILADE_STATUS_UNUSABLE = 13,
    /// A fault in the library. Please report it with the message.
    ENFILADE_STATUS_PANIC = 14,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum EnfiladeStatus EnfiladeStatus;
#else
typedef uint32_t EnfiladeStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Flags of EnfiladeItemOptions.
enum EnfiladeItemFlags
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Its faces hide nothing: its mesh only approximates what is drawn.
    ENFILADE_ITEM_FLAGS_NO_OCCLUDER = 1,
    /// It hides, but is never visible itself: a proxy inside of what is drawn.
    ENFILADE_ITEM_FLAGS_NOT_DRAWN = 2,
    /// Each look into its sector finds it, even if it is hidden or out of view.
    ENFILADE_ITEM_FLAGS_NEVER_CULL = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum EnfiladeItemFlags EnfiladeItemFlags;
#else
typedef uint32_t EnfiladeItemFlags;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// What stops a ray.
enum EnfiladeRayEnd
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Nothing: it goes on for ever.
    ENFILADE_RAY_END_NOTHING = 0,
    /// A face of an item.
    ENFILADE_RAY_END_FACE = 1,
    /// A portal that is closed.
    ENFILADE_RAY_END_CLOSED = 2,
    /// More portals than are followed, 256.
    ENFILADE_RAY_END_LIMIT = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum EnfiladeRayEnd EnfiladeRayEnd;
#else
typedef uint32_t EnfiladeRayEnd;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// The vertical axis.
enum EnfiladeUp
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Found out from the floors.
    ENFILADE_UP_DETECT = 0,
    /// +x.
    ENFILADE_UP_X = 1,
    /// +y.
    ENFILADE_UP_Y = 2,
    /// +z.
    ENFILADE_UP_Z = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum EnfiladeUp EnfiladeUp;
#else
typedef uint32_t EnfiladeUp;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// What is between two rooms.
enum EnfiladeDoorKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// A door or gate that can be opened and closed.
    ENFILADE_DOOR_KIND_DOOR = 0,
    /// Glass: seen through, not passed.
    ENFILADE_DOOR_KIND_WINDOW = 1,
    /// Nothing: always open.
    ENFILADE_DOOR_KIND_OPENING = 2,
    /// A hole too small to pass: light and sound pass.
    ENFILADE_DOOR_KIND_GAP = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum EnfiladeDoorKind EnfiladeDoorKind;
#else
typedef uint32_t EnfiladeDoorKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// How a sector finds out what is visible. The book says which to use when; ENFILADE_METHOD_MASKED suits most.
enum EnfiladeMethod
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Masked occlusion culling: fast; conservative. It keeps two depths per 32 x 8 pixels, so that an item behind a wall may stay
    /// visible where a floor begins; with ENFILADE_TIGHTNESS_RESOLVED it does not.
    ENFILADE_METHOD_MASKED = 0,
    /// Occlusion tree over boxes: valid at any sample position (MSAA, TAA, dynamic resolution).
    ENFILADE_METHOD_MOBSP = 1,
    /// Occlusion tree over faces: as ENFILADE_METHOD_MOBSP, fewer hidden items, slower.
    ENFILADE_METHOD_SVBSP = 2,
    /// Hierarchical z-buffer: exact.
    ENFILADE_METHOD_HIERARCHICAL_Z = 3,
    /// Hierarchical s-buffer: exact.
    ENFILADE_METHOD_HIERARCHICAL_S = 4,
    /// Z-buffer: exact, slow.
    ENFILADE_METHOD_Z_BUFFER = 5,
    /// S-buffer: exact.
    ENFILADE_METHOD_S_BUFFER = 6,
    /// Baked PVS: for files that hold one.
    ENFILADE_METHOD_PVS = 7,
    /// Convex cell: for convex rooms.
    ENFILADE_METHOD_CELL = 8,
    /// BSP tree, back to front: exact, for scenes that do not change.
    ENFILADE_METHOD_BSP = 9,
    /// BSP tree, front to back: exact, for scenes that do not change.
    ENFILADE_METHOD_BSP_FRONT = 10,
    /// Floating horizon: for terrain of a file.
    ENFILADE_METHOD_FLOATING_HORIZON = 11,
    /// Painter's algorithm by nearest points: approximate.
    ENFILADE_METHOD_PAINTER_MIN = 12,
    /// Painter's algorithm by centres: approximate.
    ENFILADE_METHOD_PAINTER_MEAN = 13,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum EnfiladeMethod EnfiladeMethod;
#else
typedef uint32_t EnfiladeMethod;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// How light passes through a material.
enum EnfiladeAlpha
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Opaque: its faces are occluders.
    ENFILADE_ALPHA_OPAQUE = 0,
    /// Alpha-tested: hides nothing.
    ENFILADE_ALPHA_MASK = 1,
    /// Alpha-blended: hides nothing.
    ENFILADE_ALPHA_BLEND = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum EnfiladeAlpha EnfiladeAlpha;
#else
typedef uint32_t EnfiladeAlpha;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Flags of EnfiladeReadOptions.
enum EnfiladeReadFlags
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Read everything as one sector, without portals and mirrors.
    ENFILADE_READ_FLAGS_FLAT = 1,
    /// Leave out portals and mirrors that are wrong, each with a warning.
    ENFILADE_READ_FLAGS_SKIP_BAD_PORTALS = 2,
    /// Leave out textures, which only enfilade_viewer_draw uses.
    ENFILADE_READ_FLAGS_NO_TEXTURES = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum EnfiladeReadFlags EnfiladeReadFlags;
#else
typedef uint32_t EnfiladeReadFlags;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Depth of the near and the far plane in clip space.
enum EnfiladeClipDepth
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// -1 near, 1 far: OpenGL, Unity's `Camera.projectionMatrix`, Godot.
    ENFILADE_CLIP_DEPTH_MINUS_ONE_TO_ONE = 0,
    /// 0 near, 1 far: Direct3D, Vulkan, Metal.
    ENFILADE_CLIP_DEPTH_ZERO_TO_ONE = 1,
    /// 1 near, 0 far (reversed depth): Unreal, Bevy.
    ENFILADE_CLIP_DEPTH_ONE_TO_ZERO = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum EnfiladeClipDepth EnfiladeClipDepth;
#else
typedef uint32_t EnfiladeClipDepth;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Flags of EnfiladeViewerOptions.
enum EnfiladeViewerFlags
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Looks use the threads of enfilade_set_threads.
    ENFILADE_VIEWER_FLAGS_USES_THREADS = 1,
    /// Do not test first what was visible before. Changes the speed only.
    ENFILADE_VIEWER_FLAGS_NO_COHERENCE = 2,
    /// Nothing hides anything: cull by the frustum and by portals alone.
    ENFILADE_VIEWER_FLAGS_NO_OCCLUSION = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum EnfiladeViewerFlags EnfiladeViewerFlags;
#else
typedef uint32_t EnfiladeViewerFlags;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// How closely ENFILADE_METHOD_MASKED tests what it found once more, when all occluders are known.
enum EnfiladeTightness
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// By boxes.
    ENFILADE_TIGHTNESS_BOXES = 0,
    /// By faces: fewer hidden items, slower.
    ENFILADE_TIGHTNESS_FACES = 1,
    /// By faces at exact depths: fewest hidden items, slowest.
    ENFILADE_TIGHTNESS_RESOLVED = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum EnfiladeTightness EnfiladeTightness;
#else
typedef uint32_t EnfiladeTightness;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Guarantee of a look.
enum EnfiladeContract
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Visible items may be missing.
    ENFILADE_CONTRACT_APPROXIMATE = 0,
    /// No item is missing that is visible at a sample of the view; hidden ones may be there.
    ENFILADE_CONTRACT_CONSERVATIVE = 1,
    /// As conservative, for any sample positions and resolutions.
    ENFILADE_CONTRACT_STRICT = 2,
    /// Exactly the items that are visible at a sample of the view.
    ENFILADE_CONTRACT_EXACT = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum EnfiladeContract EnfiladeContract;
#else
typedef uint32_t EnfiladeContract;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// What enfilade_viewer_draw shows.
enum EnfiladeShow
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// The picture.
    ENFILADE_SHOW_IMAGE = 0,
    /// Each item in a colour of its own.
    ENFILADE_SHOW_ITEMS = 1,
    /// Each sector in a colour of its own.
    ENFILADE_SHOW_SECTORS = 2,
    /// The order in which the method reached items.
    ENFILADE_SHOW_ORDER = 3,
    /// How often samples were painted.
    ENFILADE_SHOW_OVERDRAW = 4,
    /// The occlusion buffer.
    ENFILADE_SHOW_COVER = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum EnfiladeShow EnfiladeShow;
#else
typedef uint32_t EnfiladeShow;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// A mesh: triangles, or a box without any, for any number of items. Immutable. It stays in use by scenes after it was freed.
typedef struct EnfiladeMesh EnfiladeMesh;

/// Triangles that occlude. Immutable.
typedef struct EnfiladeOccluder EnfiladeOccluder;

/// A software depth buffer, for engines that keep their own scene: begin a view, draw occluders, test what they hide.
///
/// Nothing visible at a pixel centre is reported hidden, as long as occluders are opaque and no larger than what is drawn. Tests
/// may run on several threads at once; enfilade_occlusion_begin and enfilade_occlusion_draw must be alone.
typedef struct EnfiladeOcclusion EnfiladeOcclusion;

/// Rooms of a building, and the doors, windows, openings and gaps between them. Looks use sectors instead; enfilade_scene_locate finds
/// the sector of the eye in microseconds. Queries may run on several threads at once; enfilade_rooms_set_open must be alone.
typedef struct EnfiladeRooms EnfiladeRooms;

/// A scene: sectors with items, joined by portals.
///
/// Any number of threads may look at one scene and query it at the same time, each with its own viewer. A call that changes the
/// scene must be alone: while others use it, it returns ENFILADE_STATUS_BUSY, and so do they.
typedef struct EnfiladeScene EnfiladeScene;

/// What one camera sees. Keep one for each camera: it keeps its buffers and what it saw, which makes the next look cheaper and
/// never changes it. Use it by one thread at a time.
typedef struct EnfiladeViewer EnfiladeViewer;

/// What went wrong: filled in by each call that is given one, also if nothing did.
typedef struct EnfiladeError {
    /// As the call returned it.
    EnfiladeStatus status;
    /// Always 0.
    uint32_t reserved;
    /// Index of what was refused in the array that was passed (of the first, if several were), or ENFILADE_NO_INDEX.
    uint64_t index;
    /// Stable code of the broken rule, such as `mesh/index-out-of-range`; ends with a null character. Empty on success.
    char code[48];
    /// The message: UTF-8, cut to fit, ends with a null character. Empty on success.
    char message[448];
} EnfiladeError;

/// Triangles of one material. The arrays are read during the call only.
typedef struct EnfiladeMeshPart {
    /// Positions, 3 floats each, in the space of the mesh: x, y, z.
    const float *positions;
    /// Number of positions.
    size_t position_count;
    /// Bytes from one position to the next, at least 12; 0 for 12. Any alignment.
    size_t position_stride;
    /// Three indices of positions per triangle, counter-clockwise as seen from its front. Aligned to their size.
    const void *indices;
    /// Number of indices, a multiple of three.
    size_t index_count;
    /// Bytes per index: 2 (uint16_t) or 4 (uint32_t).
    uint32_t index_size;
    /// Index of the material in the table of the sector that the items are in.
    uint32_t material;
} EnfiladeMeshPart;

/// How a file is read. All zero is a good default.
typedef struct EnfiladeReadOptions {
    /// EnfiladeReadFlags, or 0.
    uint32_t flags;
    /// An EnfiladeMethod: that of sectors for which the file names none.
    uint32_t method;
    /// Most memory that reading may take, and then each sector, in bytes; 0 for 1 GiB.
    uint64_t limit_bytes;
} EnfiladeReadOptions;

/// A material, by which faces hide what is behind them.
typedef struct EnfiladeMaterial {
    /// Red, green, blue and opacity, linear, 0 to 1; for enfilade_viewer_draw.
    float color[4];
    /// An EnfiladeAlpha.
    uint32_t alpha;
    /// 1 if faces are visible from both sides, 0 if back-faces are culled.
    uint32_t double_sided;
    /// 1 for plants, crockery and the like, whose faces are too small to be occluders; else 0.
    uint32_t detail;
} EnfiladeMaterial;

/// A sector of a scene. 0 is none, or, where the documentation says so, any.
typedef uint64_t EnfiladeSectorId;

/// What a sector is.
typedef struct EnfiladeSectorInfo {
    /// Lower corner of the box around its items; greater than box_max if it has none.
    float box_min[3];
    /// Upper corner of that box.
    float box_max[3];
    /// Number of items.
    uint64_t item_count;
    /// Number of triangles of all items.
    uint64_t triangle_count;
    /// An EnfiladeMethod; UINT32_MAX for terrain that is read from its file on demand.
    uint32_t method;
    /// Always 0.
    uint32_t reserved;
    /// Its name, cut to fit.
    char name[64];
} EnfiladeSectorInfo;

/// A camera by its parameters.
typedef struct EnfiladeCamera {
    /// Position of the eye, in the space of its sector.
    double eye[3];
    /// A point in the centre of the picture, not the eye.
    double target[3];
    /// Up vector, of any length; zero for +y. If it is parallel to the direction of view, another is taken.
    double up[3];
    /// Vertical field of view in radians, above 0 and below pi; 0 for 60 degrees.
    float fov_y;
    /// Distance of the near plane, above 0; 0 for a small one that suits the scene's scale.
    float near_distance;
    /// For an orthographic camera the height that it shows, in scene units; the eye is then in the near plane. 0 for perspective.
    float parallel_height;
    /// Must be 0.
    uint32_t reserved;
    /// The sector that the eye is in; 0, as for most cameras of files: found by its position.
    EnfiladeSectorId sector;
    /// Name of a camera of a file, cut to fit; ignored as input.
    char name[64];
} EnfiladeCamera;

/// How an item takes part in looks. All zero is a good default.
typedef struct EnfiladeItemOptions {
    /// EnfiladeItemFlags, or 0.
    uint32_t flags;
    /// The layers it is in, one bit each; 0 for all. Viewers look at layers.
    uint32_t layers;
    /// Distance from which on looks ignore it, in scene units; 0 for no limit.
    float max_distance;
    /// Diameter on the screen below which looks ignore it, in pixels.
    float min_size_px;
} EnfiladeItemOptions;

/// An item to add.
typedef struct EnfiladeItem {
    /// Its mesh, which may be freed afterwards.
    const struct EnfiladeMesh *mesh;
    /// Your number for it: answers name it by its key, and bit sets have a bit for each key, so use small ones if you use those.
    uint64_t key;
    /// The transform from the space of the mesh to that of the sector: 16 floats, column after column, as in EnfiladeView. The
    /// last row must be 0, 0, 0, 1.
    float sector_from_item[16];
    /// How it takes part in looks.
    struct EnfiladeItemOptions options;
    /// UTF-8; null for none. Copied.
    const char *name;
} EnfiladeItem;

/// An item of a scene. 0 is none.
typedef uint64_t EnfiladeItemId;

/// What an item is.
typedef struct EnfiladeItemInfo {
    /// Its sector.
    EnfiladeSectorId sector;
    /// Its key.
    uint64_t key;
    /// Its transform, as in EnfiladeItem.
    float sector_from_item[16];
    /// Lower corner of its box, in the space of the sector.
    float box_min[3];
    /// Upper corner of its box.
    float box_max[3];
    /// How it takes part in looks.
    struct EnfiladeItemOptions options;
    /// Number of triangles of its mesh; 0 for a box.
    uint64_t triangle_count;
    /// Its name, cut to fit.
    char name[64];
} EnfiladeItemInfo;

/// A portal of a scene. 0 is none.
typedef uint64_t EnfiladePortalId;

/// A portal: a one-way link out of a sector. A door is two portals, a mirror one that leads back.
typedef struct EnfiladePortal {
    /// Its id.
    EnfiladePortalId portal;
    /// The sector that it leads out of.
    EnfiladeSectorId from;
    /// The sector that it leads into.
    EnfiladeSectorId to;
    /// The transform from the space of the first sector to that of the second: 16 floats, column after column.
    float there_from_here[16];
    /// Lower corner of the box around its outline, in the space of the first sector.
    float box_min[3];
    /// Upper corner of that box.
    float box_max[3];
    /// 1 if it is open, 0 if it is closed: opaque.
    uint32_t is_open;
    /// Always 0.
    uint32_t reserved;
} EnfiladePortal;

/// A camera with its viewport: the matrices that the frame is drawn with.
///
/// Matrices are 16 doubles, column after column, and multiply column vectors: the clip position of a point is clip_from_eye x
/// eye_from_sector x (x, y, z, 1). A matrix of rows that multiply row vectors (DirectXMath, Unreal) has the same numbers in the
/// same order. Right- or left-handed, any up axis, off-centre, jittered, infinite or reversed depth, orthographic, oblique near
/// plane. There is no far plane: what is beyond it counts as visible. Matrices that mirror, as of a planar reflection, leave
/// visible, and occluding, the same sides of faces: flip the winding of your renderer for them.
///
/// If too much or too little is visible, print one matrix: a view matrix has the translation in its last four numbers, and a
/// perspective projection -1 or 1 as number 11 (the first is 0). A wrong clip_depth between the first two is not noticed.
typedef struct EnfiladeView {
    /// The view matrix.
    double eye_from_sector[16];
    /// The projection matrix.
    double clip_from_eye[16];
    /// The sector that the eye is in, whose space eye_from_sector starts from; 0: found by the position of the eye.
    EnfiladeSectorId sector;
    /// An EnfiladeClipDepth: that of clip_from_eye.
    uint32_t clip_depth;
    /// Left edge of the viewport, in pixels of the render target. Moves the scissors of passages only.
    uint32_t left;
    /// Top edge of the viewport, in pixels of the render target.
    uint32_t top;
    /// Width of the viewport, 1 to 16384 pixels.
    uint32_t width;
    /// Height of the viewport, 1 to 16384 pixels.
    uint32_t height;
    /// Must be 0.
    uint32_t reserved;
} EnfiladeView;

/// How a viewer looks. All zero is a good default.
typedef struct EnfiladeViewerOptions {
    /// EnfiladeViewerFlags, or 0.
    uint32_t flags;
    /// The layers to look at, one bit each; 0 for all.
    uint32_t layers;
    /// An EnfiladeTightness.
    uint32_t tightness;
    /// Most portals in a row that are followed, up to 65535; 0 for 64.
    uint32_t max_crossings;
    /// Most passages of a look; 0 for 65536.
    uint32_t max_passages;
    /// Most occluders per passage, for methods that select occluders; 0 for a number that suits the method.
    uint32_t max_occluders;
    /// How far the renderer may move vertices, 0 to 0.5 pixels; expensive, and proven. Mostly 0.
    float margin_px;
    /// How far tested boxes grow, 0 to 8 pixels; cheap. 1 for multisampling, and for GPUs that snap vertices.
    float growth_px;
} EnfiladeViewerOptions;

/// What a look found, in numbers.
typedef struct EnfiladeLook {
    /// Number of visible items; one that is visible through two passages counts twice.
    size_t item_count;
    /// Number of passages.
    size_t passage_count;
    /// An EnfiladeContract: that of all passages.
    uint32_t contract;
    /// 1, or 0 if items may be missing because a limit of EnfiladeViewerOptions ended the look, or the scene has no sector.
    uint32_t is_complete;
} EnfiladeLook;

/// The keys of visible items, each once, ascending, and how they changed. The arrays belong to the viewer, and are valid until its
/// next look, draw or end.
typedef struct EnfiladeKeys {
    /// Keys that are visible.
    const uint64_t *visible;
    /// Their number.
    size_t visible_count;
    /// Keys that became visible since the last enfilade_viewer_keys.
    const uint64_t *entered;
    /// Their number.
    size_t entered_count;
    /// Keys that are no longer visible since the last enfilade_viewer_keys.
    const uint64_t *left;
    /// Their number.
    size_t left_count;
} EnfiladeKeys;

/// A visible item.
typedef struct EnfiladeVisibleItem {
    /// Its key.
    uint64_t key;
    /// Its id; 0 for a block of terrain that is read from its file on demand, and for an item that was removed since the look.
    EnfiladeItemId item;
    /// The passage that it is visible through: an index among those of enfilade_viewer_passages.
    uint32_t passage;
    /// Longer side of its rectangle on the screen, in pixels.
    uint32_t size_px;
    /// 1 if visible parts are alpha-blended, else 0.
    uint32_t blends;
    /// Always 0.
    uint32_t reserved;
} EnfiladeVisibleItem;

/// A passage: a chain of portals from the eye into a sector. Draw the items of each passage with its matrix, scissor and plane.
typedef struct EnfiladePassage {
    /// The view-projection matrix, from the space of the sector to clip space: 16 doubles, column after column.
    double clip_from_sector[16];
    /// Only points with ax + by + cz + d >= 0 are visible: the plane of the last opening, in the space of the sector. All zero if
    /// there is none.
    double clip_plane[4];
    /// The sector at its end.
    EnfiladeSectorId sector;
    /// The last portal; 0 for the sector of the eye.
    EnfiladePortalId portal;
    /// Scissor rectangle in pixels of the render target, y down: left, top, width, height.
    uint32_t scissor[4];
    /// Index of the passage one portal nearer to the eye; UINT32_MAX for none.
    uint32_t parent;
    /// Number of portals.
    uint32_t crossings;
} EnfiladePassage;

/// How enfilade_viewer_draw draws. All zero is a good default.
typedef struct EnfiladeDrawOptions {
    /// An EnfiladeShow.
    uint32_t show;
    /// Samples per pixel: 1 (or 0), or 4.
    uint32_t samples;
    /// 1 if lights cast shadows, else 0.
    uint32_t shadows;
    /// Rays per pixel for ambient occlusion, up to 1024; 0 for none.
    uint32_t ambient_rays;
    /// Exposure: displayed value of a unit of light; 0 for 1.
    float exposure;
} EnfiladeDrawOptions;

/// A position in a scene.
typedef struct EnfiladeLocation {
    /// The sector.
    EnfiladeSectorId sector;
    /// Coordinates in the space of the sector.
    float position[3];
    /// Must be 0.
    uint32_t reserved;
} EnfiladeLocation;

/// Where a ray ends.
typedef struct EnfiladeHit {
    /// Distance over all portals, in lengths of the direction; infinite if nothing is hit.
    double distance;
    /// The sector that it ends in.
    EnfiladeSectorId sector;
    /// The item that is hit, or 0.
    EnfiladeItemId item;
    /// The key of that item.
    uint64_t key;
    /// An EnfiladeRayEnd.
    uint32_t end;
    /// 1 if the face is hit from behind, else 0.
    uint32_t from_behind;
} EnfiladeHit;

/// An item near a location.
typedef struct EnfiladeNearItem {
    /// Its key.
    uint64_t key;
    /// Its id.
    EnfiladeItemId item;
    /// Its sector.
    EnfiladeSectorId sector;
    /// Length of the shortest way to its box, through open portals.
    double distance;
} EnfiladeNearItem;

/// A body that slides along walls: a cylinder with round ends.
typedef struct EnfiladeCapsule {
    /// Radius, above 0.
    float radius;
    /// Height, with the round ends; a sphere if at most twice the radius.
    float height;
    /// Direction of its axis, of any length but 0.
    float up[3];
    /// Height of a step that it climbs, or 0.
    float climb;
} EnfiladeCapsule;

/// How rooms are found. All zero is a good default.
typedef struct EnfiladeRoomOptions {
    /// Metres per scene unit; 0: guessed from the height of rooms.
    double metres_per_unit;
    /// Side of a voxel in metres; 0 for 0.1.
    double voxel;
    /// Most voxels, of which one takes about 5 bytes; 0 for 60 million. Voxels are larger if there would be more.
    uint64_t max_voxels;
    /// An EnfiladeUp.
    uint32_t up;
    /// 1 to ignore the sectors of the scene; else these are the rooms, if there are several.
    uint32_t ignores_sectors;
} EnfiladeRoomOptions;

/// A room of an EnfiladeRooms. 0 is none.
typedef uint64_t EnfiladeRoomId;

/// A room.
typedef struct EnfiladeRoom {
    /// Its id.
    EnfiladeRoomId room;
    /// Volume of its free space, in cubic metres.
    double volume;
    /// Floor area, in square metres.
    double area;
    /// Lower corner of the box around it, in scene coordinates.
    double box_min[3];
    /// Upper corner of that box.
    double box_max[3];
    /// Its storey, counted from the lowest.
    uint32_t storey;
    /// 1 for what is outside of the building, else 0.
    uint32_t is_outside;
    /// Its name, cut to fit.
    char name[64];
} EnfiladeRoom;

/// A door of an EnfiladeRooms. 0 is none.
typedef uint64_t EnfiladeDoorId;

/// A door, a window, an opening or a gap between two rooms.
typedef struct EnfiladeDoor {
    /// Its id.
    EnfiladeDoorId door;
    /// The rooms on its two sides.
    EnfiladeRoomId rooms[2];
    /// The item that opens and closes; 0 if there is none, or the rooms were read.
    EnfiladeItemId leaf;
    /// Area without opaque parts other than the leaf, in square metres.
    double area;
    /// A rectangle in it: 4 corners of 3 doubles, in scene coordinates.
    double corners[12];
    /// An EnfiladeDoorKind.
    uint32_t kind;
    /// 1 if bodies can pass, else 0.
    uint32_t is_open;
} EnfiladeDoor;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Returns the version of the library, as ENFILADE_VERSION is that of the header.
uint32_t enfilade_version(void);

/// Sets the number of threads that calls may use that build, read files or find rooms, and looks by viewers with
/// ENFILADE_VIEWER_FLAGS_USES_THREADS. The threads are shared by the whole process, and wait for work.
///
/// @param count 1 to 256; 0 for one per core. Until the first call, and with 1, every call runs on the thread that makes it,
/// and the library starts none.
///
/// Results do not depend on it. Calls that run already keep the threads that they have.
EnfiladeStatus enfilade_set_threads(uint32_t count, struct EnfiladeError *error);

/// Creates a mesh from triangles. Free it with enfilade_mesh_free.
///
/// @param version ENFILADE_VERSION.
/// @param parts The parts, one for each material; none for a mesh without triangles, whose items are never visible. Positions
/// that no triangle uses may hold anything.
/// @param mesh Receives the mesh.
///
/// Errors: ENFILADE_STATUS_BAD_MESH for an index out of range, positions that are not finite or beyond 1e18, indices that are no
/// whole triangles; the index is that of the part.
EnfiladeStatus enfilade_mesh_create(uint32_t version,
                                    const struct EnfiladeMeshPart *parts,
                                    size_t part_count,
                                    struct EnfiladeMesh **mesh,
                                    struct EnfiladeError *error);

/// Creates a mesh that is only a box: an item with it is visible where its box may be, and hides nothing. For skinned and
/// animated objects (a box around all poses), particles, lights, and objects whose triangles are not loaded yet.
///
/// @param version ENFILADE_VERSION.
/// @param box_min 3 floats, each less than in @p box_max.
/// @param box_max 3 floats.
/// @param mesh Receives the mesh.
///
/// Errors: ENFILADE_STATUS_BAD_MESH.
EnfiladeStatus enfilade_mesh_create_box(uint32_t version,
                                        const float *box_min,
                                        const float *box_max,
                                        struct EnfiladeMesh **mesh,
                                        struct EnfiladeError *error);

/// Frees a mesh. Items that use it keep it. Null is ignored.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE if it was freed before.
EnfiladeStatus enfilade_mesh_free(struct EnfiladeMesh *mesh);

/// Creates an empty scene. Free it with enfilade_scene_free.
///
/// @param version ENFILADE_VERSION.
/// @param scene Receives the scene.
EnfiladeStatus enfilade_scene_create(uint32_t version, struct EnfiladeScene **scene, struct EnfiladeError *error);

/// Reads a scene from a file: glTF 2.0 (.glb, .gltf), OBJ, a compiled map of Quake or Quake 3 (.bsp), or a heightmap (.json).
/// Rooms, portals and mirrors that the author marked become sectors and portals. Items have the keys 0, 1, 2, ...
///
/// @param version ENFILADE_VERSION.
/// @param path Path of the file, UTF-8.
/// @param options Null for the defaults.
/// @param scene Receives the scene.
///
/// Errors: ENFILADE_STATUS_BAD_FILE, with a message that names the place in the file; ENFILADE_STATUS_BAD_SCENE and
/// ENFILADE_STATUS_TOO_LARGE.
EnfiladeStatus enfilade_scene_read_file(uint32_t version,
                                        const char *path,
                                        const struct EnfiladeReadOptions *options,
                                        struct EnfiladeScene **scene,
                                        struct EnfiladeError *error);

/// Reads a scene from the bytes of a file, as enfilade_scene_read_file; other files that it refers to are not read.
///
/// @param version ENFILADE_VERSION.
/// @param bytes The bytes, which are read during the call only.
/// @param options Null for the defaults.
/// @param scene Receives the scene.
///
/// Errors: as enfilade_scene_read_file.
EnfiladeStatus enfilade_scene_read_memory(uint32_t version,
                                          const uint8_t *bytes,
                                          size_t byte_count,
                                          const struct EnfiladeReadOptions *options,
                                          struct EnfiladeScene **scene,
                                          struct EnfiladeError *error);

/// Frees a scene. Null is ignored. Viewers that looked at it stay.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE if it was freed before.
EnfiladeStatus enfilade_scene_free(struct EnfiladeScene *scene);

/// Adds a sector: a room, a region, or all of a scene without rooms. Then add its items, and connect it by a door or portal.
///
/// @param name UTF-8; null for none.
/// @param method An EnfiladeMethod.
/// @param materials The materials of the sector, to which its meshes refer by index; they stay as they are.
/// @param sector Receives the id.
///
/// Errors: ENFILADE_STATUS_BAD_SCENE if the method needs what the sector lacks.
EnfiladeStatus enfilade_scene_add_sector(struct EnfiladeScene *scene,
                                         const char *name,
                                         uint32_t method,
                                         const struct EnfiladeMaterial *materials,
                                         size_t material_count,
                                         EnfiladeSectorId *sector,
                                         struct EnfiladeError *error);

/// Removes a sector with its items, and all portals into and out of it.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
EnfiladeStatus enfilade_scene_remove_sector(struct EnfiladeScene *scene, EnfiladeSectorId sector, struct EnfiladeError *error);

/// Replaces the method of a sector, and rebuilds what it needs. With the same method: rebuilds trees that many moves have made
/// slow.
///
/// @param method An EnfiladeMethod.
///
/// Errors: ENFILADE_STATUS_BAD_SCENE if the method needs what the sector lacks; ENFILADE_STATUS_TOO_LARGE.
EnfiladeStatus enfilade_scene_set_method(struct EnfiladeScene *scene,
                                         EnfiladeSectorId sector,
                                         uint32_t method,
                                         struct EnfiladeError *error);

/// Lists the sectors, oldest first.
///
/// @param sectors Receives up to @p capacity ids; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
EnfiladeStatus enfilade_scene_sectors(const struct EnfiladeScene *scene,
                                      EnfiladeSectorId *sectors,
                                      size_t capacity,
                                      size_t *count,
                                      struct EnfiladeError *error);

/// Describes a sector.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
EnfiladeStatus enfilade_scene_sector(const struct EnfiladeScene *scene,
                                     EnfiladeSectorId sector,
                                     struct EnfiladeSectorInfo *info,
                                     struct EnfiladeError *error);

/// Lists the cameras of the file that the scene was read from.
///
/// @param cameras Receives up to @p capacity cameras; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
EnfiladeStatus enfilade_scene_cameras(const struct EnfiladeScene *scene,
                                      struct EnfiladeCamera *cameras,
                                      size_t capacity,
                                      size_t *count,
                                      struct EnfiladeError *error);

/// Returns what was strange in the file that the scene was read from: lines of UTF-8, without a null character at the end.
///
/// @param text Receives up to @p capacity bytes; null to get their number alone.
/// @param count Receives their number, 0 if nothing was strange.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
EnfiladeStatus enfilade_scene_warnings(const struct EnfiladeScene *scene,
                                       char *text,
                                       size_t capacity,
                                       size_t *count,
                                       struct EnfiladeError *error);

/// Adds items to a sector.
///
/// Adds as many as it can: the id of one that is refused is 0, the status is why the first was, and the index of the error is
/// its index.
///
/// @param items The items.
/// @param count Their number.
/// @param ids Receives their ids; room for @p count.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE for a mesh, ENFILADE_STATUS_BAD_ARGUMENT for a transform, a material that the sector
/// lacks, or options; ENFILADE_STATUS_TOO_LARGE, and then none is added.
EnfiladeStatus enfilade_scene_add_items(struct EnfiladeScene *scene,
                                        EnfiladeSectorId sector,
                                        const struct EnfiladeItem *items,
                                        size_t count,
                                        EnfiladeItemId *ids,
                                        struct EnfiladeError *error);

/// Removes items. Their ids are invalid from then on, and never name other items.
///
/// Removes as many as it can; the status and the index of the error are those of the first that was refused.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
EnfiladeStatus enfilade_scene_remove_items(struct EnfiladeScene *scene,
                                           const EnfiladeItemId *ids,
                                           size_t count,
                                           struct EnfiladeError *error);

/// Moves items: replaces their transforms. Report everything that moves, or it is culled where it was.
///
/// Moves as many as it can; the status and the index of the error are those of the first that was refused. One that is refused
/// stays where it was, so draw it without culling until a transform is accepted.
///
/// Allocates nothing once the buffers of the scene have grown, except where nodes of a tree split.
///
/// @param ids The items; several transforms of one item: the last counts.
/// @param count Their number.
/// @param transforms One for each item: 16 floats, column after column, as EnfiladeItem::sector_from_item.
/// @param stride Bytes from one transform to the next, at least 64; 0 for 64. Any alignment.
/// @param refused Null, or one word for each 64 items: receives bit i % 64 of word i / 64 for each item i that was refused.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT for a transform that is not finite or leads beyond 1e18;
/// ENFILADE_STATUS_TOO_LARGE, and then none is moved.
EnfiladeStatus enfilade_scene_move_items(struct EnfiladeScene *scene,
                                         const EnfiladeItemId *ids,
                                         size_t count,
                                         const float *transforms,
                                         size_t stride,
                                         uint64_t *refused,
                                         struct EnfiladeError *error);

/// Replaces the options of items.
///
/// Changes as many as it can; the status and the index of the error are those of the first that was refused.
///
/// @param options One for each item.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT.
EnfiladeStatus enfilade_scene_set_options(struct EnfiladeScene *scene,
                                          const EnfiladeItemId *ids,
                                          size_t count,
                                          const struct EnfiladeItemOptions *options,
                                          struct EnfiladeError *error);

/// Replaces the keys of items.
///
/// Changes as many as it can; the status and the index of the error are those of the first that was refused.
///
/// @param keys One for each item.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
EnfiladeStatus enfilade_scene_set_keys(struct EnfiladeScene *scene,
                                       const EnfiladeItemId *ids,
                                       size_t count,
                                       const uint64_t *keys,
                                       struct EnfiladeError *error);

/// Replaces the mesh of an item and keeps its transform: for a mesh that was loaded after the item, or another LOD.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_HANDLE, ENFILADE_STATUS_BAD_ARGUMENT for a material that the sector
/// lacks.
EnfiladeStatus enfilade_scene_set_mesh(struct EnfiladeScene *scene,
                                       EnfiladeItemId item,
                                       const struct EnfiladeMesh *mesh,
                                       struct EnfiladeError *error);

/// Moves an item to another sector, with its id, key, mesh and options. The materials of its mesh are those of the new sector
/// with the same numbers.
///
/// @param sector_from_item Its transform in the new sector: 16 floats.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT.
EnfiladeStatus enfilade_scene_transfer_item(struct EnfiladeScene *scene,
                                            EnfiladeItemId item,
                                            EnfiladeSectorId sector,
                                            const float *sector_from_item,
                                            struct EnfiladeError *error);

/// Lists the items of a sector, or of all sectors.
///
/// @param sector 0 for all.
/// @param ids Receives up to @p capacity ids; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
EnfiladeStatus enfilade_scene_items(const struct EnfiladeScene *scene,
                                    EnfiladeSectorId sector,
                                    EnfiladeItemId *ids,
                                    size_t capacity,
                                    size_t *count,
                                    struct EnfiladeError *error);

/// Describes an item.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
EnfiladeStatus enfilade_scene_item(const struct EnfiladeScene *scene,
                                   EnfiladeItemId item,
                                   struct EnfiladeItemInfo *info,
                                   struct EnfiladeError *error);

/// Adds a door: two portals, one each way, between sectors that share a space. Leave a hole in the walls there.
///
/// @param a A sector.
/// @param b Another, or the same.
/// @param corners The outline: at least three corners of 3 floats, flat, convex, counter-clockwise as seen from @p a.
/// @param stride Bytes from one corner to the next, at least 12; 0 for 12.
/// @param count Number of corners.
/// @param portals Receives two ids: of the portal out of @p a, then of that out of @p b.
///
/// Errors: ENFILADE_STATUS_BAD_MESH for the outline, with the index of the corner; ENFILADE_STATUS_NO_SUCH_ID;
/// ENFILADE_STATUS_BAD_SCENE.
EnfiladeStatus enfilade_scene_add_door(struct EnfiladeScene *scene,
                                       EnfiladeSectorId a,
                                       EnfiladeSectorId b,
                                       const float *corners,
                                       size_t stride,
                                       size_t count,
                                       EnfiladePortalId *portals,
                                       struct EnfiladeError *error);

/// Adds a portal that leads one way: a mirror, a teleport, a window that is seen through from one side.
///
/// @param from The sector that it leads out of.
/// @param corners The outline, as of enfilade_scene_add_door, counter-clockwise as seen from @p from.
/// @param stride Bytes from one corner to the next, at least 12; 0 for 12.
/// @param count Number of corners.
/// @param to The sector that it leads into.
/// @param there_from_here 16 floats: the transform from the space of @p from to that of @p to: rigid, scaling alike in all
/// directions, or reflecting. Null: a mirror in the plane of the outline if @p to is @p from, else none.
/// @param portal Receives the id.
///
/// Errors: as enfilade_scene_add_door; ENFILADE_STATUS_BAD_SCENE for a transform that shears.
EnfiladeStatus enfilade_scene_add_portal(struct EnfiladeScene *scene,
                                         EnfiladeSectorId from,
                                         const float *corners,
                                         size_t stride,
                                         size_t count,
                                         EnfiladeSectorId to,
                                         const float *there_from_here,
                                         EnfiladePortalId *portal,
                                         struct EnfiladeError *error);

/// Removes a portal with its opening. The other portal of a door stays.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
EnfiladeStatus enfilade_scene_remove_portal(struct EnfiladeScene *scene, EnfiladePortalId portal, struct EnfiladeError *error);

/// Opens or closes a portal. A closed one is opaque. Close both portals of a door.
///
/// @param is_open 0 to close it.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
EnfiladeStatus enfilade_scene_set_open(struct EnfiladeScene *scene,
                                       EnfiladePortalId portal,
                                       uint32_t is_open,
                                       struct EnfiladeError *error);

/// Lists the portals out of a sector, or all.
///
/// @param sector 0 for all.
/// @param portals Receives up to @p capacity portals; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
EnfiladeStatus enfilade_scene_portals(const struct EnfiladeScene *scene,
                                      EnfiladeSectorId sector,
                                      struct EnfiladePortal *portals,
                                      size_t capacity,
                                      size_t *count,
                                      struct EnfiladeError *error);

/// Returns the view of a camera: its matrices, with reversed depth.
///
/// @param width Width of the viewport, 1 to 16384 pixels.
/// @param height Height of the viewport, 1 to 16384 pixels.
/// @param view Receives the view.
///
/// Errors: ENFILADE_STATUS_BAD_VIEW for numbers that are not finite or out of range.
EnfiladeStatus enfilade_view_from_camera(const struct EnfiladeCamera *camera,
                                         uint32_t width,
                                         uint32_t height,
                                         struct EnfiladeView *view,
                                         struct EnfiladeError *error);

/// Creates a viewer that has seen nothing. Free it with enfilade_viewer_free.
///
/// @param version ENFILADE_VERSION.
/// @param options Null for the defaults.
/// @param viewer Receives the viewer.
///
/// Errors: ENFILADE_STATUS_BAD_ARGUMENT.
EnfiladeStatus enfilade_viewer_create(uint32_t version,
                                      const struct EnfiladeViewerOptions *options,
                                      struct EnfiladeViewer **viewer,
                                      struct EnfiladeError *error);

/// Frees a viewer. Null is ignored.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE if it was freed before.
EnfiladeStatus enfilade_viewer_free(struct EnfiladeViewer *viewer);

/// Replaces the options of a viewer; it keeps what it saw.
///
/// @param options Null for the defaults.
///
/// Errors: ENFILADE_STATUS_BAD_ARGUMENT.
EnfiladeStatus enfilade_viewer_set_options(struct EnfiladeViewer *viewer,
                                           const struct EnfiladeViewerOptions *options,
                                           struct EnfiladeError *error);

/// Determines what is visible. Read it with enfilade_viewer_bits, enfilade_viewer_keys, enfilade_viewer_items and
/// enfilade_viewer_passages.
///
/// Starts no thread, and allocates nothing once the buffers of the viewer have grown, but for plans through several sectors. A look
/// that is refused changes nothing: what was visible before can still be read.
///
/// The method of each sector decides how long it takes (enfilade_scene_set_method); ENFILADE_METHOD_MASKED is mostly the fastest.
///
/// @param look Null, or receives the result in numbers.
///
/// Errors: ENFILADE_STATUS_BAD_VIEW; ENFILADE_STATUS_NO_SUCH_ID for the sector of the view; ENFILADE_STATUS_TOO_LARGE if buffers
/// for the screen would take more than 1 GB.
EnfiladeStatus enfilade_viewer_look(struct EnfiladeViewer *viewer,
                                    const struct EnfiladeScene *scene,
                                    const struct EnfiladeView *view,
                                    struct EnfiladeLook *look,
                                    struct EnfiladeError *error);

/// Writes the last look as bits: bit key % 64 of word key / 64 is 1 if an item with this key is visible, else 0.
/// Before the first look all bits are 1: nothing is known to be hidden.
///
/// @param words The bits, which are cleared first.
/// @param word_count Number of words: one for each 64 keys.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL if a visible key has no bit, with the key as index; the bits of the others are right.
EnfiladeStatus enfilade_viewer_bits(const struct EnfiladeViewer *viewer,
                                    uint64_t *words,
                                    size_t word_count,
                                    struct EnfiladeError *error);

/// Returns the keys of the last look, and those that entered and left since the last call of this function: what to show and to
/// hide. A second call after the same look returns the same.
///
/// @param keys Receives the arrays, which belong to the viewer.
EnfiladeStatus enfilade_viewer_keys(struct EnfiladeViewer *viewer, struct EnfiladeKeys *keys, struct EnfiladeError *error);

/// Lists the visible items of the last look, passage after passage.
///
/// @param scene The scene that was looked at.
/// @param items Receives up to @p capacity items; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
EnfiladeStatus enfilade_viewer_items(const struct EnfiladeViewer *viewer,
                                     const struct EnfiladeScene *scene,
                                     struct EnfiladeVisibleItem *items,
                                     size_t capacity,
                                     size_t *count,
                                     struct EnfiladeError *error);

/// Lists the passages of the last look. The first is that of the sector of the eye; without portals it is the only one.
///
/// @param scene The scene that was looked at.
/// @param passages Receives up to @p capacity passages; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
EnfiladeStatus enfilade_viewer_passages(const struct EnfiladeViewer *viewer,
                                        const struct EnfiladeScene *scene,
                                        struct EnfiladePassage *passages,
                                        size_t capacity,
                                        size_t *count,
                                        struct EnfiladeError *error);

/// Draws a view in software: to show what is culled, and to test. It is a look, too: what is visible can be read afterwards.
///
/// @param options Null for the defaults.
/// @param rgba Receives the picture: rows from top to bottom, 4 bytes per pixel (red, green, blue, 255), sRGB.
/// @param row_bytes Bytes from one row to the next, at least 4 x width; 0 for that.
/// @param byte_count Bytes that @p rgba has room for, at least row_bytes x height.
///
/// Errors: as enfilade_viewer_look; ENFILADE_STATUS_BUFFER_TOO_SMALL.
EnfiladeStatus enfilade_viewer_draw(struct EnfiladeViewer *viewer,
                                    const struct EnfiladeScene *scene,
                                    const struct EnfiladeView *view,
                                    const struct EnfiladeDrawOptions *options,
                                    uint8_t *rgba,
                                    size_t row_bytes,
                                    size_t byte_count,
                                    struct EnfiladeError *error);

/// Finds the sector that contains a point: the smallest of those whose boxes do, else the nearest.
///
/// @param point 3 doubles.
/// @param target Null, or 3 doubles: a point that the eye at @p point looks at, which decides in a doorway.
/// @param sector Receives the id; 0 if the scene has no sectors.
///
/// Errors: ENFILADE_STATUS_BAD_ARGUMENT for numbers that are not finite.
EnfiladeStatus enfilade_scene_locate(const struct EnfiladeScene *scene,
                                     const double *point,
                                     const double *target,
                                     EnfiladeSectorId *sector,
                                     struct EnfiladeError *error);

/// Casts a ray through open portals. All faces stop it, from both sides.
///
/// @param from Where it starts.
/// @param direction 3 floats, of any length but 0: distances are multiples of it.
/// @param hit Receives where it ends.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT.
EnfiladeStatus enfilade_scene_cast_ray(const struct EnfiladeScene *scene,
                                       const struct EnfiladeLocation *from,
                                       const float *direction,
                                       struct EnfiladeHit *hit,
                                       struct EnfiladeError *error);

/// Tests the line of sight between two locations, straight or through open portals. All faces block it.
///
/// @param sees Receives 1 if nothing is between them, else 0.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT.
EnfiladeStatus enfilade_scene_sees(const struct EnfiladeScene *scene,
                                   const struct EnfiladeLocation *from,
                                   const struct EnfiladeLocation *to,
                                   uint32_t *sees,
                                   struct EnfiladeError *error);

/// Finds the items within a distance, along ways through open portals. Walls within a sector are no obstacle.
///
/// @param radius In scene units, 0 or more.
/// @param items Receives up to @p capacity items, nearest first; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL, ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT; ENFILADE_STATUS_TOO_LARGE
/// if there are so many ways that some were not followed: items are missing.
EnfiladeStatus enfilade_scene_near(const struct EnfiladeScene *scene,
                                   const struct EnfiladeLocation *from,
                                   float radius,
                                   struct EnfiladeNearItem *items,
                                   size_t capacity,
                                   size_t *count,
                                   struct EnfiladeError *error);

/// Moves a point through the open portals that it crosses: a camera, a projectile. Nothing else stops it.
///
/// @param location Where it is; receives where it is then.
/// @param step 3 floats, in the space of the start.
/// @param there_from_here Null, or receives 16 floats: the transform from the space of the start to that of the end, for
/// velocities and orientations.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT; the location stays as it was.
EnfiladeStatus enfilade_scene_walk(const struct EnfiladeScene *scene,
                                   struct EnfiladeLocation *location,
                                   const float *step,
                                   float *there_from_here,
                                   struct EnfiladeError *error);

/// Moves a body: it slides along walls, climbs low steps, and passes through open portals. Add gravity to the step.
///
/// @param capsule The body; receives it as the portals have turned and scaled it.
/// @param location Where its centre is; receives where it is then.
/// @param step 3 floats, in the space of the start.
/// @param there_from_here Null, or receives 16 floats, as of enfilade_scene_walk.
/// @param on_ground Null, or receives 1 if it stands on something, else 0.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID, ENFILADE_STATUS_BAD_ARGUMENT; the body stays as it was.
EnfiladeStatus enfilade_scene_slide(const struct EnfiladeScene *scene,
                                    struct EnfiladeCapsule *capsule,
                                    struct EnfiladeLocation *location,
                                    const float *step,
                                    float *there_from_here,
                                    uint32_t *on_ground,
                                    struct EnfiladeError *error);

/// Creates an occluder from triangles. Free it with enfilade_occluder_free.
///
/// @param version ENFILADE_VERSION.
/// @param part The triangles; their material is ignored. The largest first is best.
/// @param double_sided 1 if faces hide from both sides, 0 if only from their front.
/// @param occluder Receives the occluder.
///
/// Errors: ENFILADE_STATUS_BAD_MESH, with the index of the triangle.
EnfiladeStatus enfilade_occluder_create(uint32_t version,
                                        const struct EnfiladeMeshPart *part,
                                        uint32_t double_sided,
                                        struct EnfiladeOccluder **occluder,
                                        struct EnfiladeError *error);

/// Frees an occluder. Null is ignored.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE if it was freed before.
EnfiladeStatus enfilade_occluder_free(struct EnfiladeOccluder *occluder);

/// Creates an occlusion buffer. Until enfilade_occlusion_begin, everything is visible. Free it with enfilade_occlusion_free.
///
/// @param version ENFILADE_VERSION.
/// @param occlusion Receives the buffer.
EnfiladeStatus enfilade_occlusion_create(uint32_t version, struct EnfiladeOcclusion **occlusion, struct EnfiladeError *error);

/// Frees an occlusion buffer. Null is ignored.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE if it was freed before.
EnfiladeStatus enfilade_occlusion_free(struct EnfiladeOcclusion *occlusion);

/// Clears the buffer and sets the view of the draws and tests to come. It takes half a byte per pixel of the viewport.
///
/// @param view The view; its sector is ignored.
///
/// Errors: ENFILADE_STATUS_BAD_VIEW.
EnfiladeStatus enfilade_occlusion_begin(struct EnfiladeOcclusion *occlusion,
                                        const struct EnfiladeView *view,
                                        struct EnfiladeError *error);

/// Draws instances of an occluder: what is behind them is hidden from then on. Nearest first is fastest, and hides most.
///
/// An instance with a transform that is refused hides nothing; the status and the index of the error are those of the first.
///
/// @param transforms World-from-mesh transforms: 16 floats each, column after column.
/// @param stride Bytes from one transform to the next, at least 64; 0 for 64.
/// @param count Number of instances.
///
/// Errors: ENFILADE_STATUS_BAD_ARGUMENT.
EnfiladeStatus enfilade_occlusion_draw(struct EnfiladeOcclusion *occlusion,
                                       const struct EnfiladeOccluder *occluder,
                                       const float *transforms,
                                       size_t stride,
                                       size_t count,
                                       struct EnfiladeError *error);

/// Tests boxes: sets bit i % 64 of word i / 64 to 1 if any part of box i may be visible, and to 0 if occluders hide all of it or it
/// is out of view. Empty boxes are hidden, boxes that are not finite visible.
///
/// @param boxes 6 floats each: lower corner, upper corner, in world space.
/// @param stride Bytes from one box to the next, at least 24; 0 for 24. Any alignment.
/// @param count Number of boxes.
/// @param visible One word for each 64 boxes.
///
/// Allocates nothing.
EnfiladeStatus enfilade_occlusion_test_boxes(const struct EnfiladeOcclusion *occlusion,
                                             const float *boxes,
                                             size_t stride,
                                             size_t count,
                                             uint64_t *visible,
                                             struct EnfiladeError *error);

/// Copies the depth buffer, to show it: reversed depth (1 / distance along the view direction; larger is nearer, 0 where nothing
/// hides) at each pixel, row by row from the top.
///
/// @param depths Receives up to @p capacity floats; null to get their number alone.
/// @param count Receives their number: width x height of the view.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
EnfiladeStatus enfilade_occlusion_depths(const struct EnfiladeOcclusion *occlusion,
                                         float *depths,
                                         size_t capacity,
                                         size_t *count,
                                         struct EnfiladeError *error);

/// Finds the rooms of a scene, and the doors and windows between them; for what is found, see the book. All doors with a leaf are
/// closed at first. Takes seconds, for a palace ten or more: write the result with enfilade_rooms_write.
///
/// @param version ENFILADE_VERSION.
/// @param options Null for the defaults.
/// @param rooms Receives the rooms. Free them with enfilade_rooms_free.
///
/// Errors: ENFILADE_STATUS_BAD_SCENE if there are no triangles; ENFILADE_STATUS_BAD_ARGUMENT.
EnfiladeStatus enfilade_rooms_find(uint32_t version,
                                   const struct EnfiladeScene *scene,
                                   const struct EnfiladeRoomOptions *options,
                                   struct EnfiladeRooms **rooms,
                                   struct EnfiladeError *error);

/// Reads rooms that enfilade_rooms_write or the program `enfilade rooms` wrote.
///
/// @param version ENFILADE_VERSION.
/// @param json UTF-8, without a null character at the end.
/// @param rooms Receives the rooms. Free them with enfilade_rooms_free.
///
/// Errors: ENFILADE_STATUS_BAD_FILE.
EnfiladeStatus enfilade_rooms_read(uint32_t version,
                                   const uint8_t *json,
                                   size_t byte_count,
                                   struct EnfiladeRooms **rooms,
                                   struct EnfiladeError *error);

/// Writes rooms as JSON. Which doors are open is not part of it.
///
/// @param json Receives up to @p capacity bytes; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
EnfiladeStatus enfilade_rooms_write(const struct EnfiladeRooms *rooms,
                                    uint8_t *json,
                                    size_t capacity,
                                    size_t *count,
                                    struct EnfiladeError *error);

/// Frees rooms. Null is ignored.
///
/// Errors: ENFILADE_STATUS_BAD_HANDLE if they were freed before.
EnfiladeStatus enfilade_rooms_free(struct EnfiladeRooms *rooms);

/// Lists the rooms.
///
/// @param list Receives up to @p capacity rooms; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL.
EnfiladeStatus enfilade_rooms_list(const struct EnfiladeRooms *rooms,
                                   struct EnfiladeRoom *list,
                                   size_t capacity,
                                   size_t *count,
                                   struct EnfiladeError *error);

/// Lists the doors, windows, openings and gaps of a room, or all. Rooms with furniture have thousands of gaps: look at their kind.
///
/// @param room 0 for all rooms.
/// @param list Receives up to @p capacity doors; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL, ENFILADE_STATUS_NO_SUCH_ID.
EnfiladeStatus enfilade_rooms_doors(const struct EnfiladeRooms *rooms,
                                    EnfiladeRoomId room,
                                    struct EnfiladeDoor *list,
                                    size_t capacity,
                                    size_t *count,
                                    struct EnfiladeError *error);

/// Finds the room at a point.
///
/// @param point 3 doubles, in scene coordinates.
/// @param room Receives the id; 0 if there is none.
///
/// Errors: ENFILADE_STATUS_BAD_ARGUMENT.
EnfiladeStatus enfilade_rooms_at(const struct EnfiladeRooms *rooms,
                                 const double *point,
                                 EnfiladeRoomId *room,
                                 struct EnfiladeError *error);

/// Opens or closes a door, and all doors and gaps with the same leaf. Windows, openings and gaps without a leaf stay as they are.
///
/// @param is_open 0 to close it.
///
/// Errors: ENFILADE_STATUS_NO_SUCH_ID.
EnfiladeStatus enfilade_rooms_set_open(struct EnfiladeRooms *rooms,
                                       EnfiladeDoorId door,
                                       uint32_t is_open,
                                       struct EnfiladeError *error);

/// Finds the shortest way between two points through open doors.
///
/// @param from 3 doubles.
/// @param to 3 doubles.
/// @param length Null, or receives the length in metres; negative if there is no way.
/// @param doors Receives up to @p capacity doors on the way; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL, ENFILADE_STATUS_BAD_ARGUMENT.
EnfiladeStatus enfilade_rooms_path(const struct EnfiladeRooms *rooms,
                                   const double *from,
                                   const double *to,
                                   double *length,
                                   EnfiladeDoorId *doors,
                                   size_t capacity,
                                   size_t *count,
                                   struct EnfiladeError *error);

/// Returns how far a sound seems: the length of the way through doors, and 15 m for a closed door, 20 m for a window, 10 m for a
/// gap.
///
/// @param listener 3 doubles.
/// @param source 3 doubles.
/// @param distance Receives metres; negative if there is no way.
///
/// Errors: ENFILADE_STATUS_BAD_ARGUMENT.
EnfiladeStatus enfilade_rooms_heard(const struct EnfiladeRooms *rooms,
                                    const double *listener,
                                    const double *source,
                                    double *distance,
                                    struct EnfiladeError *error);

/// Lists the rooms that may be seen from a room through open doors, windows, openings and gaps, itself included: an upper bound.
/// Takes milliseconds: call it when a door opens, not in each frame.
///
/// @param list Receives up to @p capacity rooms; null to get their number alone.
/// @param count Receives their number.
///
/// Errors: ENFILADE_STATUS_BUFFER_TOO_SMALL, ENFILADE_STATUS_NO_SUCH_ID.
EnfiladeStatus enfilade_rooms_relevant(const struct EnfiladeRooms *rooms,
                                       EnfiladeRoomId room,
                                       EnfiladeRoomId *list,
                                       size_t capacity,
                                       size_t *count,
                                       struct EnfiladeError *error);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ENFILADE_H */
