#include "tools/scenario/run/broken_scene.h"

#include <numeric>
#include <string>
#include <utility>

#include "physics/cutting/hull_meshes.h"
#include "physics/cutting/solid_piece.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/piece_export.h"
#include "tools/scenario/run/object_loop.h"
#include "tools/scenario/run/state_export.h"

namespace brittle::tools {

namespace {

// A surface that need not be closed, as one piece.
fracture::Fragments surface_of(const LoadedObject& object) {
    Snapshot whole;
    whole.pieces.push_back({0, must(physics::fixed_solid(object.input->model.mesh)), {}});
    return live_pieces(whole, {}).fragments;
}

BrokenObject broken_object(const LoadedObject& object, uint32_t threads) {
    Broken broken = break_object(object, threads);
    return {std::move(broken.fragments), broken.certificate, broken.milliseconds,
            object.object.recipe.unite ? std::string() : overlap_of(object.input->model.mesh)};
}

} // namespace

FractureOptions with_cuts(FractureOptions scene) {
    for (SceneObject& object : scene.objects)
        if (!object.fixed && !object.in_pieces && object.recipe.world.breakable && !object.recipe.world.bonded)
            object.shattered = true;
    scene.glue.clear(); // holds no loose pieces
    return scene;
}

std::vector<BrokenObject> break_scene(LoadedScene& scene, const Host& host,
                                      const std::function<void(double)>& progress) {
    std::vector<BrokenObject> objects(scene.objects.size());
    std::vector<std::string> faults(scene.objects.size());
    std::vector<size_t> all(scene.objects.size());
    std::iota(all.begin(), all.end(), size_t{0});
    ObjectLoop loop(scene, host, progress, all.size());
    loop.share_among(all);
    loop.run(all, [&](size_t k) {
        try {
            if (!scene.objects[k].object.fixed) objects[k] = broken_object(scene.objects[k], loop.threads_for(k));
        } catch (const Failure& failure) {
            if (failure.code() != exit_mesh) throw;
            faults[k] = failure.what();
            fix(scene.objects[k].object);
        }
        if (scene.objects[k].object.fixed) objects[k].fragments = surface_of(scene.objects[k]);
    });
    for (const size_t k : all)
        if (!faults[k].empty()) scene.notes.push_back(note_of(scene.objects[k].object, faults[k]));
    return objects;
}

void add_pieces(fracture::ObjectExport& file, const ExportSettings& settings, const LoadedScene& scene,
                std::span<const BrokenObject> objects) {
    for (size_t k = 0; k < objects.size(); ++k) {
        const LoadedObject& object = scene.objects[k];
        const fracture::Fragments& fragments = objects[k].fragments;
        std::vector<fracture::PiecePose> poses;
        for (const fracture::Piece& piece : fragments.pieces)
            poses.push_back(made_pose(object.placement, piece.mass.centre_of_mass));
        fracture::ExportOptions options = export_options(settings, object.object.recipe, *object.input);
        options.images = object.images.get();
        options.name = object.object.name;
        options.sites = object.input->sites;
        options.uv_by_plane = options.sites.empty();
        options.poses = poses;
        options.fixed = object.object.fixed;
        std::vector<std::vector<fracture::TriangleMesh>> hulls;
        if (wants_hulls(settings) && !object.object.fixed) {
            hulls = physics::hull_meshes(fragments, hull_settings(settings));
            options.hulls = hulls;
        }
        must(file.add(fragments, options));
    }
}

} // namespace brittle::tools
