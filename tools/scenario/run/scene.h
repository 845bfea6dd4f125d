// A scene: objects from a recipe, loaded, broken where they start in pieces, and prepared for a simulation. A recipe of
// one mesh is not a scene (recipe/input.h).
//
//     LoadedScene scene = load_scene(options, host);
//     std::vector<PreparedObject> objects = prepare_scene(scene, host, payload_maker(renderer));   // on any thread
//     Stage stage(renderer, scene.home);
//     stage.stand(std::move(objects), scene.world);
//
// The nodes of a level come before the objects of the recipe. Objects that differ in place and name alone share mesh,
// solids and hulls, as do instances of one mesh of a glTF file. A mesh that cannot be broken becomes a fixed
// object, with a note; a file that cannot be read is a Failure that names the object.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fracture/mesh/mesh.h"
#include "physics/cutting/piece_payload.h"
#include "physics/world/world.h"
#include "tools/scenario/recipe/host.h"
#include "tools/scenario/recipe/input.h"
#include "tools/scenario/run/prepared_object.h"

namespace brittle::tools {

struct SceneCache;

struct LoadedObject {
    SceneObject object;                 // as in the recipe; fixed also where its mesh cannot be broken
    std::shared_ptr<const Input> input; // in metres of the object; objects may share it
    // Of the model of `input`, which has none itself; null unless the scene was loaded with looks.
    std::shared_ptr<const std::vector<fracture::Image>> images;
    physics::Pose placement;
    fracture::Box box;    // in the world
    bool refused = false; // it should break, but its mesh cannot be broken
};

struct LoadedScene {
    std::vector<LoadedObject> objects{};
    std::vector<Glue> glue{};         // of the recipe
    WorldOptions world{};             // the members that concern no single object
    uint32_t threads = 0;             // 0: one per core
    fracture::Box home{};             // around all objects that are not fixed; around all where none moves
    std::vector<std::string> notes{}; // for people: meshes that cannot be broken, and why; faults of a level
};

// Replaces the level of a scene by the objects that it stands for, so that each can be edited. Returns notes for people
// about faults of the level. Throws a Failure.
[[nodiscard]] std::vector<std::string> expand_level(FractureOptions& scene);

// Reads the files one after another and makes the meshes side by side; the result is the same for any number of threads.
// The host is called from any thread. Throws a Failure: that of the first file that cannot be read, or else of the first
// object that cannot be made. `cache` (scene_cache.h) holds what earlier calls made, and may be null. `with_looks`: the models of
// the objects keep their materials, textures and attributes of corners, for an export.
[[nodiscard]] LoadedScene load_scene(const FractureOptions& scene, const Host& host = {}, SceneCache* cache = nullptr,
                                     bool with_looks = false);

// Moves and turns a loaded object. Its scale and shear must stay.
void place(LoadedObject& object, const ObjectPlacement& placement);
// Sets `home` once objects have been placed.
void find_home(LoadedScene& scene);

// Turns an object whose mesh cannot be broken into a fixed one.
void fix(SceneObject& object);
// A note about such an object, for people.
[[nodiscard]] std::string note_of(const SceneObject& object, const std::string& fault);

// The pieces with which an object that is not fixed starts: its whole parts, those that its sites make, or those of its
// file, bonded where they touch. On any thread. Throws a Failure.
[[nodiscard]] Broken break_object(const LoadedObject& object, uint32_t threads);

// Breaks and prepares the objects, side by side; the result is in their order, and the same for any number of threads.
// An object that cannot be cut becomes fixed, with a note in the scene. The host and `payload` are called from any thread, `progress`
// by one at a time with rising shares up to 1. Throws a Failure: that of the first object that cannot be prepared.
[[nodiscard]] std::vector<PreparedObject> prepare_scene(LoadedScene& scene, const Host& host = {},
                                                        const DrawingMaker& payload = {},
                                                        const std::function<void(double)>& progress = {},
                                                        SceneCache* cache = nullptr);

} // namespace brittle::tools
