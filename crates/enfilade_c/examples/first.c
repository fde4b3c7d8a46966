#include "enfilade.h"
#include <stdio.h>
static EnfiladeError error;
#define TRY(call) if ((call) != ENFILADE_STATUS_OK) return fprintf(stderr, "%s: %s\n", error.code, error.message), 1
int main(void) {
    const float square[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    const uint16_t triangles[] = {0, 1, 2, 0, 2, 3};
    const EnfiladeMeshPart part = {.positions = square, .position_count = 4, .indices = triangles, .index_count = 6, .index_size = 2};
    const EnfiladeMaterial grey = {.color = {0.6f, 0.6f, 0.6f, 1.0f}};
    const EnfiladeCamera camera = {.target = {0, 0, -1}};
    EnfiladeMesh *mesh; EnfiladeScene *scene; EnfiladeViewer *viewer;
    EnfiladeSectorId room; EnfiladeItemId ids[2]; EnfiladeView view; uint64_t bits;
    TRY(enfilade_mesh_create(ENFILADE_VERSION, &part, 1, &mesh, &error));
    TRY(enfilade_scene_create(ENFILADE_VERSION, &scene, &error));
    TRY(enfilade_scene_add_sector(scene, "room", ENFILADE_METHOD_MASKED, &grey, 1, &room, &error));
    const EnfiladeItem items[] = { // 4 and 9 units ahead: the first hides the second
        {.mesh = mesh, .key = 0, .sector_from_item = {1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, -4, 1}},
        {.mesh = mesh, .key = 1, .sector_from_item = {1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, -9, 1}}};
    TRY(enfilade_scene_add_items(scene, room, items, 2, ids, &error));
    TRY(enfilade_viewer_create(ENFILADE_VERSION, NULL, &viewer, &error));
    TRY(enfilade_view_from_camera(&camera, 1280, 720, &view, &error));
    TRY(enfilade_viewer_look(viewer, scene, &view, NULL, &error)); // each frame
    TRY(enfilade_viewer_bits(viewer, &bits, 1, &error));
    for (int key = 0; key < 2; key++) printf("item %d is %s\n", key, bits >> key & 1 ? "visible" : "hidden");
    return enfilade_viewer_free(viewer) | enfilade_scene_free(scene) | enfilade_mesh_free(mesh);
}
