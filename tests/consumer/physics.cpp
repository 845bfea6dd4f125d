// Uses every part of the installed libraries that a game needs, from its own arrays to falling pieces:
// consumer_physics
#include <cstdint>
#include <cstdio>
#include <vector>

#include <fracture/fracture.h>
#include <fracture/io/export.h>
#include <fracture/io/import.h>
#include <fracture/io/piece_surface.h>
#include <fracture/io/weld.h>
#include <fracture/pieces/certificate.h>
#include <fracture/sites/sites.h>
#include <fracture/unite/unite.h>
#include <physics/bonds/structure.h>
#include <physics/cutting/convex_parts.h>
#include <physics/cutting/destruction.h>

namespace bf = brittle::fracture;
namespace bp = brittle::physics;

// A cube as engines keep it: four vertices a face.
bf::TriangleMesh engine_cube(const glm::dvec3& at) {
    bf::TriangleMesh mesh;
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {0.0, 1.0}) {
            const auto base = static_cast<uint32_t>(mesh.positions.size());
            for (int corner = 0; corner < 4; ++corner) {
                glm::dvec3 p(0.0);
                p[axis] = side;
                p[(axis + 1) % 3] = corner == 1 || corner == 2;
                p[(axis + 2) % 3] = corner >= 2;
                mesh.positions.push_back(p + at);
            }
            const uint32_t b = side > 0.0 ? 1 : 3, d = side > 0.0 ? 3 : 1;
            mesh.triangles.push_back({base, base + b, base + 2});
            mesh.triangles.push_back({base, base + 2, base + d});
        }
    }
    return mesh;
}

int fail(const char* what) {
    std::fprintf(stderr, "%s\n", what);
    return 1;
}

int main() {
    bf::TriangleMesh two = bf::weld(engine_cube({0.0, 0.0, 0.0}));
    if (two.positions.size() != 8) return fail("weld: a cube has 8 vertices");
    const bf::TriangleMesh other = bf::weld(engine_cube({0.5, 0.5, 0.5}));
    for (const bf::Triangle& triangle : other.triangles)
        two.triangles.push_back(triangle + static_cast<uint32_t>(two.positions.size()));
    two.positions.insert(two.positions.end(), other.positions.begin(), other.positions.end());

    bf::Model model;
    model.mesh = bf::unite(two).mesh;
    const auto sites = bf::uniform_sites(bf::bounds(model.mesh), 12, 1);
    const bf::Settings settings{.rough = {.amount = 0.3}};
    const bf::Result<bf::Fragments> fragments = bf::fracture(model.mesh, sites, settings);
    if (!fragments) return fail(fragments.error().message.c_str());
    const bf::Certificate certificate = bf::certify(model.mesh, *fragments);
    if (!certificate.closed || certificate.volume_error > 1e-6) return fail("the pieces are not sound");

    for (const bf::Piece& piece : fragments->pieces) {
        for (const bf::DrawnPart& part : bf::drawn_parts(*fragments, piece, {.source = &model, .sites = sites}))
            if (part.normals.size() != part.vertices.size()) return fail("a drawn part lacks normals");
        if (bp::convex_parts(fragments->positions_of(piece), fragments->triangles_of(piece), piece.mass.volume,
                             piece.mass.centre_of_mass)
                .empty())
            return fail("a piece has no convex part");
    }
    const auto files = bf::export_pieces_to_memory("pieces.glb", *fragments, certificate, {.source = &model});
    if (!files) return fail(files.error().message.c_str());
    const bf::Result<bf::Model> again = bf::import_model(files->front().bytes, ".glb");
    if (!again) return fail(again.error().message.c_str());

    for (const bp::EngineKind engine : {bp::EngineKind::solver, bp::EngineKind::bullet}) {
        bp::World world({.engine = engine});
        bp::Destruction destruction;
        const bp::Material stone = bp::material_preset("stone")->material;
        bp::BreakableDesc desc{.solid = {.material = stone}};
        desc.motion.placement.position = {0.0f, 1.0f, 0.0f};
        if (!destruction.add(world, model.mesh, desc)) return fail("the object is refused");
        destruction.strike(world, destruction.pieces().front(), {0.5f, 1.5f, 1.0f}, {0.0f, 0.0f, -1.0f}, 3000.0);
        for (int step = 0; step < 60; ++step) {
            world.step();
            destruction.update(world);
        }
        std::printf("%s: %zu pieces after the blow\n", bp::to_string(engine), destruction.pieces().size());
        if (destruction.pieces().size() < 2) return fail("the blow broke nothing");
        if (!bp::Structure::create(world, *fragments, {.material = stone})) return fail("the structure is refused");
    }
    return 0;
}
