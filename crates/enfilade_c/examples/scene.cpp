// C++17: owners that free themselves, errors as exceptions, and two viewers on two threads that look at one scene.
#include "enfilade.h"

#include <array>
#include <cstdio>
#include <cstdint>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace {

void check(EnfiladeStatus status, const EnfiladeError &error) {
    if (status != ENFILADE_STATUS_OK) throw std::runtime_error(std::string(error.code) + ": " + error.message);
}

struct Free {
    void operator()(EnfiladeMesh *mesh) const { enfilade_mesh_free(mesh); }
    void operator()(EnfiladeScene *scene) const { enfilade_scene_free(scene); }
    void operator()(EnfiladeViewer *viewer) const { enfilade_viewer_free(viewer); }
};
using Mesh = std::unique_ptr<EnfiladeMesh, Free>;
using Scene = std::unique_ptr<EnfiladeScene, Free>;
using Viewer = std::unique_ptr<EnfiladeViewer, Free>;

Mesh cube() {
    static const float corners[8][3] = {{-1, 0, -1}, {1, 0, -1}, {-1, 2, -1}, {1, 2, -1},
                                        {-1, 0, 1},  {1, 0, 1},  {-1, 2, 1},  {1, 2, 1}};
    static const std::uint16_t triangles[] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                              2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
    EnfiladeMeshPart part{};
    part.positions = corners[0];
    part.position_count = 8;
    part.indices = triangles;
    part.index_count = 36;
    part.index_size = 2;
    EnfiladeMesh *mesh = nullptr;
    EnfiladeError error;
    check(enfilade_mesh_create(ENFILADE_VERSION, &part, 1, &mesh, &error), error);
    return Mesh(mesh);
}

// A grid of 40 by 25 houses.
Scene city(const Mesh &house) {
    EnfiladeScene *created = nullptr;
    EnfiladeError error;
    check(enfilade_scene_create(ENFILADE_VERSION, &created, &error), error);
    Scene scene(created);
    EnfiladeMaterial brick{};
    brick.color[0] = 0.7f;
    brick.color[3] = 1.0f;
    EnfiladeSectorId sector = 0;
    check(enfilade_scene_add_sector(scene.get(), "city", ENFILADE_METHOD_MASKED, &brick, 1, &sector, &error), error);
    std::vector<EnfiladeItem> items;
    for (int number = 0; number < 1000; number++) {
        EnfiladeItem item{};
        item.mesh = house.get();
        item.key = static_cast<std::uint64_t>(number);
        for (int axis = 0; axis < 4; axis++) item.sector_from_item[5 * axis] = 1;
        item.sector_from_item[12] = static_cast<float>(number % 40) * 4 - 80;
        item.sector_from_item[14] = static_cast<float>(number / 40) * -4 - 4;
        items.push_back(item);
    }
    std::vector<EnfiladeItemId> ids(items.size());
    check(enfilade_scene_add_items(scene.get(), sector, items.data(), items.size(), ids.data(), &error), error);
    return scene;
}

// The number of houses that a walker sees on eight steps.
std::size_t walk(const EnfiladeScene *scene, double start) {
    EnfiladeViewer *created = nullptr;
    EnfiladeError error;
    check(enfilade_viewer_create(ENFILADE_VERSION, nullptr, &created, &error), error);
    Viewer viewer(created);
    std::size_t seen = 0;
    for (int step = 0; step < 8; step++) {
        EnfiladeCamera camera{};
        const std::array<double, 3> eye{start + step, 1.7, 2};
        for (std::size_t axis = 0; axis < 3; axis++) camera.eye[axis] = camera.target[axis] = eye[axis];
        camera.target[2] -= 1;
        EnfiladeView view;
        check(enfilade_view_from_camera(&camera, 1280, 720, &view, &error), error);
        check(enfilade_viewer_look(viewer.get(), scene, &view, nullptr, &error), error);
        EnfiladeKeys keys;
        check(enfilade_viewer_keys(viewer.get(), &keys, &error), error);
        seen += keys.visible_count;
    }
    return seen;
}

} // namespace

int main() {
    try {
        const Mesh house = cube();
        const Scene scene = city(house);
        std::array<std::size_t, 2> seen{};
        std::array<std::exception_ptr, 2> failed;
        std::vector<std::thread> walkers;
        for (std::size_t number = 0; number < 2; number++)
            walkers.emplace_back([&, number] {
                try {
                    seen[number] = walk(scene.get(), number ? 10.0 : -40.0);
                } catch (...) {
                    failed[number] = std::current_exception();
                }
            });
        for (std::thread &walker : walkers) walker.join();
        for (const std::exception_ptr &why : failed)
            if (why) std::rethrow_exception(why);
        std::printf("of 1000 houses %zu and %zu are visible at a time\n", seen[0] / 8, seen[1] / 8);
        return seen[0] > 0 && seen[0] / 8 < 300 ? 0 : 1;
    } catch (const std::exception &why) {
        std::fprintf(stderr, "%s\n", why.what());
        return 1;
    }
}
