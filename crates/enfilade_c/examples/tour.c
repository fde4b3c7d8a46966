// Every part of the interface in use: two rooms and a door, a mirror, edits, what enters and leaves, a picture, queries, the
// occlusion buffer alone, rooms of a building. Each result is checked: it is a test, too.
#include "enfilade.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static EnfiladeError error;

static void fail(const char *what, int line) {
    fprintf(stderr, "line %d: %s: %s (%s)\n", line, what, error.message, error.code);
    exit(1);
}
#define TRY(call) \
    do { \
        if ((call) != ENFILADE_STATUS_OK) fail(#call, __LINE__); \
    } while (0)
#define CHECK(condition) \
    do { \
        if (!(condition)) fail(#condition, __LINE__); \
    } while (0)

enum { WALL = 1, VASE = 2, LAMP = 3, CLOCK = 4, ROBOT = 70 };

static EnfiladeItem item_at(const EnfiladeMesh *mesh, uint64_t key, float x, float y, float z) {
    const EnfiladeItem item = {
        .mesh = mesh, .key = key, .sector_from_item = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1}};
    return item;
}

// A mesh from an interleaved vertex buffer with 32-bit indices.
static EnfiladeMesh *box(float x, float y, float z) {
    struct {
        float position[3], normal[3], texture[2];
    } vertices[8];
    memset(vertices, 0, sizeof vertices);
    for (int corner = 0; corner < 8; corner++) {
        vertices[corner].position[0] = corner & 1 ? x : -x;
        vertices[corner].position[1] = corner & 2 ? y : -y;
        vertices[corner].position[2] = corner & 4 ? z : -z;
        vertices[corner].normal[0] = NAN; // Not looked at.
    }
    static const uint32_t triangles[] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                         2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
    const EnfiladeMeshPart part = {.positions = vertices[0].position,
                                   .position_count = 8,
                                   .position_stride = sizeof vertices[0],
                                   .indices = triangles,
                                   .index_count = 36,
                                   .index_size = 4};
    EnfiladeMesh *mesh;
    TRY(enfilade_mesh_create(ENFILADE_VERSION, &part, 1, &mesh, &error));
    return mesh;
}

static int sees(EnfiladeViewer *viewer, uint64_t key) {
    uint64_t bits[2];
    TRY(enfilade_viewer_bits(viewer, bits, 2, &error));
    return bits[key / 64] >> key % 64 & 1;
}

static void two_rooms(void) {
    const EnfiladeMaterial materials[] = {{.color = {0.8f, 0.7f, 0.6f, 1}}, {.color = {0.2f, 0.4f, 0.9f, 1}}};
    EnfiladeMesh *cube = box(0.2f, 0.6f, 0.2f);
    EnfiladeScene *scene;
    EnfiladeSectorId hall, study;
    TRY(enfilade_scene_create(ENFILADE_VERSION, &scene, &error));
    TRY(enfilade_scene_add_sector(scene, "hall", ENFILADE_METHOD_MASKED, materials, 2, &hall, &error));
    TRY(enfilade_scene_add_sector(scene, "study", ENFILADE_METHOD_HIERARCHICAL_Z, materials, 2, &study, &error));

    EnfiladeItem in_hall = item_at(cube, VASE, 1, 0.6f, -2);
    in_hall.name = "vase";
    EnfiladeItem in_study[] = {item_at(cube, LAMP, 0, 0.6f, -6), item_at(cube, CLOCK, 3, 0.6f, -4)};
    EnfiladeItemId vase, things[2];
    TRY(enfilade_scene_add_items(scene, hall, &in_hall, 1, &vase, &error));
    TRY(enfilade_scene_add_items(scene, study, in_study, 2, things, &error));

    const float doorway[] = {-0.5f, 0, -3, 0.5f, 0, -3, 0.5f, 2, -3, -0.5f, 2, -3};
    EnfiladePortalId door[2];
    TRY(enfilade_scene_add_door(scene, hall, study, doorway, 0, 4, door, &error));

    // The matrices of an engine: the eye at (0, 1, 0) looks along -z; reversed depth.
    const EnfiladeView view = {.eye_from_sector = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1},
                               .clip_from_eye = {1, 0, 0, 0, 0, 1.5, 0, 0, 0, 0, 0, -1, 0, 0, 0.1, 0},
                               .clip_depth = ENFILADE_CLIP_DEPTH_ONE_TO_ZERO,
                               .sector = hall,
                               .width = 480,
                               .height = 320};
    EnfiladeViewer *viewer;
    EnfiladeLook look;
    TRY(enfilade_viewer_create(ENFILADE_VERSION, NULL, &viewer, &error));
    TRY(enfilade_viewer_look(viewer, scene, &view, &look, &error));
    CHECK(look.is_complete == 1 && look.passage_count == 2 && look.item_count == 2);
    CHECK(look.contract == ENFILADE_CONTRACT_CONSERVATIVE);
    CHECK(sees(viewer, VASE) && sees(viewer, LAMP) && !sees(viewer, CLOCK));

    // What enters and leaves: the clock moves before the doorway's axis, the vase goes.
    EnfiladeKeys keys;
    TRY(enfilade_viewer_keys(viewer, &keys, &error));
    CHECK(keys.visible_count == 2 && keys.entered_count == 2 && keys.left_count == 0);
    EnfiladeItemInfo info;
    TRY(enfilade_scene_item(scene, things[1], &info, &error));
    CHECK(info.key == CLOCK && info.sector == study && info.triangle_count == 12);
    info.sector_from_item[12] = 0.2f;
    TRY(enfilade_scene_move_items(scene, &things[1], 1, info.sector_from_item, 0, NULL, &error));
    TRY(enfilade_scene_remove_items(scene, &vase, 1, &error));
    TRY(enfilade_viewer_look(viewer, scene, &view, NULL, &error));
    TRY(enfilade_viewer_keys(viewer, &keys, &error));
    CHECK(keys.entered_count == 1 && keys.entered[0] == CLOCK && keys.left_count == 1 && keys.left[0] == VASE);

    // An id that was removed names nothing, also when the place is taken again.
    CHECK(enfilade_scene_item(scene, vase, &info, &error) == ENFILADE_STATUS_NO_SUCH_ID);
    EnfiladeItemId next;
    EnfiladeItem robot = item_at(cube, ROBOT, 0.5f, 0.6f, -2);
    TRY(enfilade_scene_add_items(scene, hall, &robot, 1, &next, &error));
    CHECK(next != vase && enfilade_scene_item(scene, vase, &info, &error) == ENFILADE_STATUS_NO_SUCH_ID);

    // What is refused is named by its index; the others move.
    const EnfiladeItemId movers[] = {next, vase, things[0]};
    float transforms[3][16];
    for (int i = 0; i < 3; i++) {
        const EnfiladeItem at = item_at(cube, 0, 0.4f, 0.6f, -2.0f - (float)i);
        memcpy(transforms[i], at.sector_from_item, sizeof at.sector_from_item);
    }
    transforms[2][13] = NAN;
    uint64_t refused = 0;
    EnfiladeStatus status =
        enfilade_scene_move_items(scene, movers, 3, transforms[0], sizeof transforms[0], &refused, &error);
    CHECK(status == ENFILADE_STATUS_NO_SUCH_ID && error.index == 1 && refused == 6);

    // Layers, sectors, passages with their matrices and scissors.
    const EnfiladeItemOptions second_layer = {.layers = 2};
    TRY(enfilade_scene_set_options(scene, &next, 1, &second_layer, &error));
    const EnfiladeViewerOptions first_layer = {.layers = 1};
    TRY(enfilade_viewer_set_options(viewer, &first_layer, &error));
    TRY(enfilade_viewer_look(viewer, scene, &view, NULL, &error));
    CHECK(!sees(viewer, ROBOT) && sees(viewer, LAMP));
    TRY(enfilade_viewer_set_options(viewer, NULL, &error));
    TRY(enfilade_scene_transfer_item(scene, next, study, item_at(cube, 0, 0, 0.6f, -5).sector_from_item, &error));
    const uint64_t same_key = ROBOT;
    TRY(enfilade_scene_set_keys(scene, &next, 1, &same_key, &error));
    TRY(enfilade_viewer_look(viewer, scene, &view, &look, &error));
    EnfiladePassage passages[4];
    EnfiladeVisibleItem visible[8];
    size_t count;
    TRY(enfilade_viewer_passages(viewer, scene, passages, 4, &count, &error));
    CHECK(count == 2 && passages[1].portal == door[0] && passages[1].sector == study && passages[1].parent == 0);
    CHECK(passages[1].scissor[2] < 480 && passages[0].scissor[2] == 480);
    TRY(enfilade_viewer_items(viewer, scene, visible, 8, &count, &error));
    CHECK(count == look.item_count);
    int found = 0;
    for (size_t i = 0; i < count; i++) found |= visible[i].item == next && visible[i].passage == 1;
    CHECK(found);

    // A picture.
    const size_t row = 480 * 4 + 16;
    uint8_t *rgba = malloc(row * 320);
    CHECK(rgba != NULL);
    memset(rgba, 0, row * 320);
    TRY(enfilade_viewer_draw(viewer, scene, &view, NULL, rgba, row, row * 320, &error));
    size_t blue = 0;
    for (size_t i = 0; i < row * 320; i += 4) blue += rgba[i + 3] == 255;
    CHECK(blue == 480 * 320 && rgba[480 * 4] == 0);
    CHECK(enfilade_viewer_draw(viewer, scene, &view, NULL, rgba, 0, 100, &error) == ENFILADE_STATUS_BUFFER_TOO_SMALL);
    free(rgba);

    // Queries, through the door, and then before the closed one.
    EnfiladeLocation eye = {.sector = hall, .position = {0, 1, 0}};
    EnfiladeLocation there = {.sector = study, .position = {0, 1.9f, -4}};
    uint32_t in_sight;
    EnfiladeHit hit;
    const float ahead[] = {0, -0.1f, -1}, step[] = {0, 0, -3.5f};
    TRY(enfilade_scene_sees(scene, &eye, &there, &in_sight, &error));
    CHECK(in_sight == 1);
    TRY(enfilade_scene_cast_ray(scene, &eye, ahead, &hit, &error));
    CHECK(hit.end == ENFILADE_RAY_END_FACE && hit.sector == study);
    EnfiladeNearItem near_items[4];
    TRY(enfilade_scene_near(scene, &eye, 5.5f, near_items, 4, &count, &error));
    CHECK(count >= 1 && near_items[0].sector == study);
    EnfiladeLocation walker = eye;
    float there_from_here[16];
    TRY(enfilade_scene_walk(scene, &walker, step, there_from_here, &error));
    CHECK(walker.sector == study && there_from_here[0] == 1);
    EnfiladeCapsule body = {.radius = 0.2f, .height = 1.8f, .up = {0, 1, 0}};
    uint32_t on_ground;
    walker = eye;
    TRY(enfilade_scene_slide(scene, &body, &walker, step, NULL, &on_ground, &error));
    CHECK(walker.sector == study && on_ground == 0);
    for (int side = 0; side < 2; side++) TRY(enfilade_scene_set_open(scene, door[side], 0, &error));
    TRY(enfilade_scene_sees(scene, &eye, &there, &in_sight, &error));
    CHECK(in_sight == 0);
    TRY(enfilade_viewer_look(viewer, scene, &view, &look, &error));
    CHECK(look.item_count == 0 && look.passage_count == 1);
    EnfiladePortal portals[4];
    TRY(enfilade_scene_portals(scene, hall, portals, 4, &count, &error));
    CHECK(count == 1 && portals[0].portal == door[0] && portals[0].to == study && portals[0].is_open == 0);
    EnfiladeSectorId at;
    const double point[] = {0, 1, -5};
    TRY(enfilade_scene_locate(scene, point, NULL, &at, &error));
    CHECK(at == study);
    EnfiladeSectorInfo about;
    TRY(enfilade_scene_sector(scene, study, &about, &error));
    CHECK(strcmp(about.name, "study") == 0 && about.item_count == 3);

    // A mirror instead of the door.
    for (int side = 0; side < 2; side++) TRY(enfilade_scene_remove_portal(scene, door[side], &error));
    CHECK(enfilade_scene_set_open(scene, door[0], 1, &error) == ENFILADE_STATUS_NO_SUCH_ID);
    EnfiladePortalId mirror;
    TRY(enfilade_scene_add_portal(scene, hall, doorway, 0, 4, hall, NULL, &mirror, &error));
    EnfiladeItem behind_eye = item_at(cube, ROBOT, 0, 1, 2);
    TRY(enfilade_scene_add_items(scene, hall, &behind_eye, 1, &next, &error));
    TRY(enfilade_viewer_look(viewer, scene, &view, NULL, &error));
    CHECK(sees(viewer, ROBOT));
    TRY(enfilade_scene_set_method(scene, hall, ENFILADE_METHOD_MOBSP, &error));
    TRY(enfilade_viewer_look(viewer, scene, &view, &look, &error));
    CHECK(sees(viewer, ROBOT) && look.contract == ENFILADE_CONTRACT_STRICT);

    // A box until the mesh is loaded.
    const float low[] = {-1, -1, -1}, high[] = {1, 1, 1};
    EnfiladeMesh *bounds;
    TRY(enfilade_mesh_create_box(ENFILADE_VERSION, low, high, &bounds, &error));
    TRY(enfilade_scene_set_mesh(scene, next, bounds, &error));
    TRY(enfilade_scene_item(scene, next, &info, &error));
    CHECK(info.triangle_count == 0 && info.box_max[0] == 1);

    TRY(enfilade_scene_remove_sector(scene, study, &error));
    TRY(enfilade_scene_sectors(scene, NULL, 0, &count, &error));
    CHECK(count == 1);
    CHECK(enfilade_scene_item(scene, things[0], &info, &error) == ENFILADE_STATUS_NO_SUCH_ID);
    TRY(enfilade_scene_items(scene, 0, NULL, 0, &count, &error));
    CHECK(count == 1);
    CHECK(enfilade_mesh_free(bounds) == ENFILADE_STATUS_OK && enfilade_mesh_free(cube) == ENFILADE_STATUS_OK);
    CHECK(enfilade_viewer_look(viewer, scene, &view, NULL, &error) == ENFILADE_STATUS_OK);
    CHECK(enfilade_scene_free(scene) == ENFILADE_STATUS_OK && enfilade_scene_free(scene) == ENFILADE_STATUS_BAD_HANDLE);
    CHECK(enfilade_viewer_look(viewer, scene, &view, NULL, &error) == ENFILADE_STATUS_BAD_HANDLE);
    CHECK(enfilade_viewer_look((EnfiladeViewer *)scene, NULL, &view, NULL, NULL) == ENFILADE_STATUS_BAD_HANDLE);
    CHECK(enfilade_viewer_free(viewer) == ENFILADE_STATUS_OK && enfilade_viewer_free(NULL) == ENFILADE_STATUS_OK);
}

static void occlusion_buffer(void) {
    const float square[] = {-2, -2, 0, 2, -2, 0, 2, 2, 0, -2, 2, 0};
    const uint16_t triangles[] = {0, 1, 2, 0, 2, 3};
    const EnfiladeMeshPart part = {
        .positions = square, .position_count = 4, .indices = triangles, .index_count = 6, .index_size = 2};
    EnfiladeOccluder *wall;
    EnfiladeOcclusion *buffer;
    TRY(enfilade_occluder_create(ENFILADE_VERSION, &part, 0, &wall, &error));
    TRY(enfilade_occlusion_create(ENFILADE_VERSION, &buffer, &error));
    const EnfiladeCamera camera = {.target = {0, 0, -1}};
    EnfiladeView view;
    TRY(enfilade_view_from_camera(&camera, 320, 200, &view, &error));
    TRY(enfilade_occlusion_begin(buffer, &view, &error));
    const float four_ahead[] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -4, 1};
    TRY(enfilade_occlusion_draw(buffer, wall, four_ahead, 0, 1, &error));
    // 1,000 boxes with a key each: those 9 units ahead and within 1 unit are hidden.
    struct {
        uint64_t key;
        float box[6];
    } things[1000];
    for (int i = 0; i < 1000; i++) {
        const float x = (float)(i % 10) - 4.5f, z = i < 500 ? -9.0f : -3.0f;
        things[i].key = (uint64_t)i;
        const float corners[] = {x - 0.4f, -0.5f, z - 0.5f, x + 0.4f, 0.5f, z + 0.5f};
        memcpy(things[i].box, corners, sizeof corners);
    }
    uint64_t visible[16];
    TRY(enfilade_occlusion_test_boxes(buffer, things[0].box, sizeof things[0], 1000, visible, &error));
    int seen[2] = {0, 0};
    for (int i = 0; i < 1000; i++) seen[i >= 500] += visible[i / 64] >> i % 64 & 1;
    CHECK(seen[0] == 100 && seen[1] > 100);
    size_t count;
    TRY(enfilade_occlusion_depths(buffer, NULL, 0, &count, &error));
    CHECK(count == 320 * 200);
    CHECK(enfilade_occluder_free(wall) == ENFILADE_STATUS_OK && enfilade_occlusion_free(buffer) == ENFILADE_STATUS_OK);
}

static void rooms_of_a_building(void) {
    // Two rooms of 4 by 4 units, 3 high; walls between x = 4 and 4.2 with a doorway at 1.5 < z < 2.5.
    static const float walls[][6] = {
        {0, 0, -0.2f, 8.2f, 3, 0},  {0, 0, 4, 8.2f, 3, 4.2f},       {-0.2f, 0, 0, 0, 3, 4},
        {8.2f, 0, 0, 8.4f, 3, 4},   {4, 0, 0, 4.2f, 3, 1.5f},       {4, 0, 2.5f, 4.2f, 3, 4},
        {4, 2, 1.5f, 4.2f, 3, 2.5f}, {-0.2f, -0.2f, -0.2f, 8.4f, 0, 4.2f}, {-0.2f, 3, -0.2f, 8.4f, 3.2f, 4.2f}};
    enum { WALLS = sizeof walls / sizeof walls[0] };
    EnfiladeScene *scene;
    EnfiladeSectorId sector;
    const EnfiladeMaterial plaster = {.color = {0.9f, 0.9f, 0.9f, 1}};
    TRY(enfilade_scene_create(ENFILADE_VERSION, &scene, &error));
    TRY(enfilade_scene_add_sector(scene, NULL, ENFILADE_METHOD_MASKED, &plaster, 1, &sector, &error));
    EnfiladeMesh *unit = box(0.5f, 0.5f, 0.5f);
    EnfiladeItem items[WALLS];
    EnfiladeItemId ids[WALLS];
    for (int i = 0; i < WALLS; i++) {
        items[i] = item_at(unit, (uint64_t)i, 0, 0, 0);
        for (int axis = 0; axis < 3; axis++) {
            items[i].sector_from_item[5 * axis] = walls[i][axis + 3] - walls[i][axis];
            items[i].sector_from_item[12 + axis] = 0.5f * (walls[i][axis + 3] + walls[i][axis]);
        }
    }
    TRY(enfilade_scene_add_items(scene, sector, items, WALLS, ids, &error));
    EnfiladeRooms *rooms, *again;
    TRY(enfilade_rooms_find(ENFILADE_VERSION, scene, NULL, &rooms, &error));
    const double left[] = {1, 1, 1}, right[] = {7, 1, 1};
    EnfiladeRoomId here, there;
    TRY(enfilade_rooms_at(rooms, left, &here, &error));
    TRY(enfilade_rooms_at(rooms, right, &there, &error));
    CHECK(here != 0 && there != 0 && here != there);
    size_t count, bytes;
    double length, heard;
    EnfiladeDoorId way[4];
    TRY(enfilade_rooms_path(rooms, left, right, &length, way, 4, &count, &error));
    CHECK(count == 1 && length > 6);
    TRY(enfilade_rooms_heard(rooms, left, right, &heard, &error));
    CHECK(fabs(heard - length) < 1e-9);
    EnfiladeRoomId relevant[8];
    TRY(enfilade_rooms_relevant(rooms, here, relevant, 8, &count, &error));
    CHECK(count >= 2);
    EnfiladeDoor doors[32];
    TRY(enfilade_rooms_doors(rooms, here, doors, 32, &count, &error));
    size_t on_the_way = 0;
    while (on_the_way < count && doors[on_the_way].door != way[0]) on_the_way++;
    CHECK(on_the_way < count && doors[on_the_way].kind == ENFILADE_DOOR_KIND_OPENING);
    // It has no leaf, so it cannot be closed.
    TRY(enfilade_rooms_set_open(rooms, way[0], 0, &error));
    TRY(enfilade_rooms_path(rooms, left, right, NULL, NULL, 0, &count, &error));
    CHECK(count == 1);
    EnfiladeRoom list[8];
    TRY(enfilade_rooms_list(rooms, list, 8, &count, &error));
    CHECK(count >= 2 && list[0].volume > 0);
    TRY(enfilade_rooms_write(rooms, NULL, 0, &bytes, &error));
    uint8_t *json = malloc(bytes);
    CHECK(json != NULL);
    TRY(enfilade_rooms_write(rooms, json, bytes, &bytes, &error));
    TRY(enfilade_rooms_read(ENFILADE_VERSION, json, bytes, &again, &error));
    free(json);
    TRY(enfilade_rooms_at(again, right, &there, &error));
    CHECK(there != 0);
    CHECK(enfilade_rooms_free(rooms) == ENFILADE_STATUS_OK && enfilade_rooms_free(again) == ENFILADE_STATUS_OK);
    CHECK(enfilade_scene_free(scene) == ENFILADE_STATUS_OK && enfilade_mesh_free(unit) == ENFILADE_STATUS_OK);
}

static void files(const char *path) {
    EnfiladeScene *scene;
    size_t count, bytes;
    CHECK(enfilade_scene_read_file(ENFILADE_VERSION, "no such file", NULL, &scene, &error) == ENFILADE_STATUS_BAD_FILE);
    CHECK(scene == NULL && strstr(error.message, "no such file") != NULL);
    TRY(enfilade_scene_read_file(ENFILADE_VERSION, path, NULL, &scene, &error));
    EnfiladeCamera camera;
    TRY(enfilade_scene_cameras(scene, NULL, 0, &count, &error));
    CHECK(count > 0);
    EnfiladeStatus status = enfilade_scene_cameras(scene, &camera, 1, &count, &error);
    CHECK(status == (count > 1 ? ENFILADE_STATUS_BUFFER_TOO_SMALL : ENFILADE_STATUS_OK));
    EnfiladeView view;
    EnfiladeLook look;
    EnfiladeViewer *viewer;
    TRY(enfilade_view_from_camera(&camera, 320, 200, &view, &error));
    TRY(enfilade_viewer_create(ENFILADE_VERSION, NULL, &viewer, &error));
    TRY(enfilade_viewer_look(viewer, scene, &view, &look, &error));
    CHECK(look.item_count > 0);
    TRY(enfilade_scene_warnings(scene, NULL, 0, &bytes, &error));
    printf("%s: %zu visible items through %zu passages\n", camera.name, look.item_count, look.passage_count);
    CHECK(enfilade_scene_free(scene) == ENFILADE_STATUS_OK && enfilade_viewer_free(viewer) == ENFILADE_STATUS_OK);
}

int main(int argc, char **argv) {
    CHECK(enfilade_version() == ENFILADE_VERSION);
    two_rooms();
    occlusion_buffer();
    rooms_of_a_building();
    if (argc > 1) files(argv[1]);
    printf("the tour is complete\n");
    return 0;
}
