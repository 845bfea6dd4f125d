#include "tools/bench/broken_bunny.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <vector>

#include "fracture/fracture.h"
#include "fracture/io/import.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "physics/world/pieces.h"

namespace brittle::tools {

namespace {

constexpr int longest_to_sleep = 2400; // limit of steps until a heap rests

// Scaled to a height of one metre, on the ground.
fracture::TriangleMesh bunny() {
    fracture::TriangleMesh mesh =
        std::ifstream(bunny_file).good() ? *fracture::import_mesh(bunny_file) : fracture::icosphere(6);
    const fracture::Box box = fracture::bounds(mesh);
    const double longest = std::max({box.size().x, box.size().y, box.size().z});
    for (glm::dvec3& p : mesh.positions) p = (p - glm::dvec3(box.centre().x, box.min.y, box.centre().z)) / longest;
    return mesh;
}

void step_until_asleep(physics::World& world) {
    for (int step = 0; step < longest_to_sleep && world.awake_count() > 0; ++step) world.step();
}

// Poses of the pieces at rest, which takes half a minute to simulate. In another world they only have to fall asleep.
// All collide.
std::vector<physics::BodyDesc> heap_at_rest() {
    const BrokenBunny broken(sites_for_2000);
    physics::World world({.debris_size = 0.0f, .max_colliding = 0});
    if (!broken.add_to(world, {5.0f, 0.0f, 0.0f})) return {};
    step_until_asleep(world);
    std::vector<physics::BodyDesc> heap(broken.forms.size());
    for (size_t i = 0; i < heap.size(); ++i) {
        heap[i].form = broken.forms[i];
        heap[i].pose = world.pose(world.bodies()[i]);
    }
    return heap;
}

} // namespace

BrokenBunny::BrokenBunny(uint32_t sites, float height) {
    static const fracture::TriangleMesh mesh = bunny();
    fracture::TriangleMesh scaled = mesh;
    for (glm::dvec3& p : scaled.positions) p *= static_cast<double>(height);
    pieces = *fracture::fracture(scaled, fracture::uniform_sites(fracture::bounds(scaled), sites, 1));
    const auto start = std::chrono::steady_clock::now();
    forms = *physics::piece_forms(pieces, {}, physics::collision_hulls(pieces));
    form_milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

bool BrokenBunny::add_to(physics::World& world, glm::vec3 at) const {
    return physics::add_pieces(world, pieces, {}, {.placement = {at, {1.0f, 0.0f, 0.0f, 0.0f}}}, forms).has_value();
}

size_t add_sleepers(physics::World& world) {
    static const std::vector<physics::BodyDesc> heap = heap_at_rest();
    if (!world.add_bodies(heap)) return 0;
    step_until_asleep(world);
    return world.body_count() - world.awake_count();
}

} // namespace brittle::tools
