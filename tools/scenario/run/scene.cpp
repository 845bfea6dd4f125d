#include "tools/scenario/run/scene.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include <glm/common.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>

#include "fracture/base/threads.h"
#include "fracture/io/text_cursor.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/pieces/contacts.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/recipe/level.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/recipe/world_json.h"
#include "tools/scenario/run/object_loop.h"
#include "tools/scenario/run/scene_cache.h"
#include "tools/scenario/run/scene_glue.h"

namespace brittle::tools {

namespace {

using fracture::TriangleMesh;

bool is_cut_at_start(const SceneObject& object) {
    return !object.fixed && !object.in_pieces && (object.recipe.world.bonded || object.shattered);
}

// The options by which an object is broken at the start: left whole unless it is bonded or shattered.
FractureOptions start_options(const SceneObject& object) {
    FractureOptions options = object.recipe;
    options.world.breakable = object.in_pieces || !object.shattered;
    return options;
}

// Equal for objects whose meshes, and sites where they are cut at the start, are equal.
std::string mesh_key(const SceneObject& object, LengthUnit units, MeshFiles& files) {
    FractureOptions mesh;
    if (is_cut_at_start(object)) mesh = object.recipe;
    mesh.mesh = object.recipe.mesh;
    mesh.repair = object.recipe.repair;
    mesh.unite = object.recipe.unite;
    const std::optional<uint32_t> in_file = files.index_of(object);
    return recipe_json(mesh) + (object.in_pieces ? " in pieces" : "") + (in_file ? std::to_string(*in_file) : "")
           + text_of(vector_json(object.placement.shear)) + text_of(vector_json(object.placement.scale))
           + (object.fixed ? " fixed" : "") + to_string(units) + stamp_of(mesh.mesh) + " " + stamp_of(mesh.sites_file);
}

// Equal for objects of one mesh whose solids are equal. The place counts where the lowest part is anchored.
std::string solid_key(const SceneObject& object) {
    FractureOptions own = object.recipe;
    if (!is_cut_at_start(object)) own.pattern.seed = 0;
    const std::string turn = own.world.anchored ? text_of(vector_json(object.placement.rotation)) : "";
    if (object.in_pieces) return recipe_json(own) + turn + text_of(object.contact_tolerance) + " in pieces";
    return recipe_json(own) + turn + (object.shattered ? " shattered" : "") + (object.fixed ? " fixed" : "");
}

// Equal for objects of one mesh that are prepared alike, blows to come included.
std::string prepared_key(const SceneObject& object) {
    const FractureOptions& own = object.recipe; // its seed decides blows, also where it starts whole
    return solid_key(object) + " " + std::to_string(own.pattern.seed) + " " + stamp_of(own.sites_file);
}

// What an object is loaded from and for.
struct Loading {
    LengthUnit units;
    MeshFiles& files;
    const Host& host;
    bool with_looks; // of load_scene()
};

// Keeps what an export needs of the looks of a model that deform() has moved.
void keep_looks(fracture::Model& model, const ObjectPlacement& placement) {
    ObjectPlacement deformation;
    deformation.shear = placement.shear;
    deformation.scale = placement.scale;
    turn_attributes(model, linear_part(deformation));
    model.images.clear();
    model.notes.clear();
    if (fracture::has_looks(model)) return;
    model.materials.clear();
    model.textures.clear();
}

// What the file of an object has of it.
struct FileMesh {
    std::shared_ptr<const engine::MaterialSet> materials{};
    fracture::Model model{};
    std::shared_ptr<const std::vector<fracture::Image>> images{}; // LoadedObject::images
};

FileMesh read_mesh(const SceneObject& object, const Loading& loading, std::vector<std::string>& notes) {
    FileMesh mesh{.materials = loading.files.materials_of(object, loading.host.looks, notes)};
    mesh.model = loading.files.model_of(object);
    mesh.model.images.clear(); // those of all meshes at once could fill the memory
    if (!mesh.materials && !loading.with_looks) keep_mesh_only(mesh.model);
    if (loading.with_looks) mesh.images = loading.files.images_of(object);
    return mesh;
}

// Makes an object's mesh, in metres of the object, ready for a fracture unless it is fixed. On any thread.
Input make_input(const SceneObject& object, FileMesh from, const Loading& loading, const Host& host) {
    Input input;
    const std::shared_ptr<const engine::MaterialSet>& materials = from.materials;
    input.model = std::move(from.model);
    input.name = object.name;
    const double metres = object.recipe.mesh.starts_with("shape:") ? 1.0 : metres_of(loading.units);
    input.scale = metres * std::abs(object.placement.scale.x);
    if (!object.fixed && !object.in_pieces) {
        prepare_mesh(object.recipe, input, host);
        if (const std::string fault = fault_of(input.model.mesh); !fault.empty()) throw Failure(exit_mesh, fault);
    }
    deform(input.model.mesh, metres, object.placement);
    const glm::dvec3& scale = object.placement.scale;
    if (materials)
        input.looks = host.looks.looks(input.model, input.model.mesh, materials, !(scale.x * scale.y * scale.z > 0.0));
    if (loading.with_looks)
        keep_looks(input.model, object.placement);
    else
        keep_mesh_only(input.model);
    if (is_cut_at_start(object)) {
        SiteSet set = sites_for(object.recipe, input.model.mesh);
        input.sites = std::move(set.sites);
        input.groups = std::move(set.groups);
        input.weights = std::move(set.weights);
    }
    return input;
}

// Reads the meshes of a scene and makes them ready, each once: the files one after another, the rest side by side.
class MeshLoader {
  public:
    explicit MeshLoader(const Loading& loading) : loading_(loading) {}

    // Reads the mesh of an object. Throws a Failure unless a fixed object can have it.
    void read(const std::string& key, const SceneObject& object) {
        Work& work = work_.emplace_back(Work{.key = key, .object = object});
        try {
            work.from = read_mesh(object, loading_, work.notes);
        } catch (const Failure& failure) {
            if (failure.code() != exit_mesh) throw;
            work.failure = failure;
        }
    }

    // Makes the meshes, and passes each on by its key, in the order of read(), with notes about its looks. Throws the
    // Failure of the first one that cannot be made, and names its object.
    void
    finish(uint32_t threads,
           const std::function<void(const std::string& key, LoadedMesh mesh, std::span<const std::string>)>& take) {
        fracture::Threads(threads).for_each(static_cast<uint32_t>(work_.size()), [&](uint32_t k) {
            throw_if_cancelled(loading_.host);
            if (!work_[k].failure) make(work_[k]);
        });
        for (Work& work : work_) {
            try {
                if (work.failure) make_fixed(work);
            } catch (const Failure& failure) {
                throw failure.at("object " + work.object.name);
            }
            for (const std::string& text : work.reports) loading_.host.report(text);
            take(work.key, std::move(work.made), work.notes);
        }
    }

  private:
    struct Work {
        std::string key;
        SceneObject object;
        FileMesh from{};
        LoadedMesh made{};
        std::optional<Failure> failure{};
        std::vector<std::string> notes{}, reports{};
    };

    void make(Work& work) const {
        Host host = loading_.host;
        if (host.report) host.report = [&work](const std::string& text) { work.reports.push_back(text); };
        work.made.images = work.from.images;
        try {
            work.made.input =
                std::make_shared<const Input>(make_input(work.object, std::move(work.from), loading_, host));
        } catch (const Failure& failure) {
            work.failure = failure;
        }
    }
    // A mesh that cannot be broken is that of a fixed object.
    void make_fixed(Work& work) const {
        if (work.failure->code() != exit_mesh) throw *work.failure;
        work.made.fault = work.failure->what();
        work.failure.reset();
        fix(work.object);
        work.from = read_mesh(work.object, loading_, work.notes);
        make(work);
        if (work.failure) throw *work.failure;
    }

    const Loading& loading_;
    std::deque<Work> work_;
};

// Gives automatic patterns the scale of the scene, and the seeds of the objects' names.
std::vector<SceneObject> with_patterns(std::vector<SceneObject> objects, double scale) {
    for (SceneObject& object : objects) {
        if (!object.recipe.automatic || !is_cut_at_start(object)) continue;
        object.recipe.automatic->scale *= scale;
        if (object.recipe.automatic->named_seed) object.recipe.pattern.seed = seed_of_name(object.name);
        object.recipe.automatic->named_seed = false;
    }
    return objects;
}

// The objects of the level, then those of the recipe. The scene has a level.
std::vector<SceneObject> with_level(const FractureOptions& scene, MeshFiles& files, std::vector<std::string>& notes) {
    std::set<std::string> names;
    for (const SceneObject& object : scene.objects) names.insert(object.name);
    const fracture::MeshScene& file = files.scene_of(scene.level.mesh);
    LevelObjects level = level_objects(scene.level, file, metres_of(scene.units), std::move(names));
    notes = file.notes;
    notes.insert(notes.end(), level.notes.begin(), level.notes.end());
    level.objects.insert(level.objects.end(), scene.objects.begin(), scene.objects.end());
    return std::move(level.objects);
}

std::vector<SceneObject> objects_of(const FractureOptions& scene, MeshFiles& files, std::vector<std::string>& notes) {
    const bool has_level = !scene.level.mesh.empty();
    return with_patterns(has_level ? with_level(scene, files, notes) : scene.objects, scene.piece_scale);
}

fracture::Box home_of(std::span<const LoadedObject> objects) {
    const bool moves = !std::ranges::all_of(objects, [](const LoadedObject& object) { return object.object.fixed; });
    std::optional<fracture::Box> home;
    for (const LoadedObject& object : objects) {
        if (moves && object.object.fixed) continue;
        home =
            home ? fracture::Box{glm::min(home->min, object.box.min), glm::max(home->max, object.box.max)} : object.box;
    }
    return home.value_or(fracture::Box{});
}

fracture::Box box_in_world(const TriangleMesh& mesh, const physics::Pose& placement) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    fracture::Box box{glm::dvec3(infinity), glm::dvec3(-infinity)};
    const glm::dquat turn(placement.orientation);
    for (const glm::dvec3& p : mesh.positions) {
        const glm::dvec3 placed = glm::dvec3(placement.position) + turn * p;
        box = {glm::min(box.min, placed), glm::max(box.max, placed)};
    }
    return mesh.positions.empty() ? fracture::Box{} : box;
}

// The objects of a level are known only now, and an object may have become fixed.
void check_glue(const LoadedScene& scene) {
    for (size_t k = 0; k < scene.glue.size(); ++k)
        for (const LoadedObject& object : scene.objects)
            for (const int side : {0, 1}) {
                const Glue& glue = scene.glue[k];
                if (!fits_pattern(side == 0 ? glue.first : glue.second, object.object.name)) continue;
                if (const std::string refusal = refusal_of_glue(object.object); !refusal.empty())
                    throw Failure(exit_input,
                                  "/glue/" + std::to_string(k) + "/between/" + std::to_string(side) + ": " + refusal);
            }
}

} // namespace

std::vector<std::string> expand_level(FractureOptions& scene) {
    std::vector<std::string> notes;
    if (scene.level.mesh.empty()) return notes;
    MeshFiles files;
    scene.objects = with_level(scene, files, notes);
    scene.level = {};
    return notes;
}

void place(LoadedObject& object, const ObjectPlacement& placement) {
    object.object.placement = placement;
    object.placement = {glm::vec3(placement.translation), glm::quat(rotation_of(placement))};
    object.box = box_in_world(object.input->model.mesh, object.placement);
}

void fix(SceneObject& object) {
    object.fixed = true;
    object.shattered = false;
    object.in_pieces = false;
    WorldOptions& world = object.recipe.world;
    world.bonded = world.anchored = false;
    world.anchors.clear();
}

std::string note_of(const SceneObject& object, const std::string& fault) {
    return fracture::printable(object.name) + " stays whole and fixed: " + fault;
}

void find_home(LoadedScene& scene) {
    scene.home = home_of(scene.objects);
}

LoadedScene load_scene(const FractureOptions& scene, const Host& host, SceneCache* cache, bool with_looks) {
    LoadedScene loaded{.glue = scene.glue, .world = scene.world, .threads = scene.threads};
    loaded.world.height = 0.0;
    SceneCache own;
    SceneCache& known = cache ? *cache : own;
    MeshFiles& files = known.files;
    const Loading loading{scene.units, files, host, with_looks};
    const std::vector<SceneObject> objects = objects_of(scene, files, loaded.notes);
    MeshLoader loader(loading);
    std::vector<std::string> keys;
    std::set<std::string> read;
    for (const SceneObject& object : objects) {
        throw_if_cancelled(host);
        try {
            keys.push_back(mesh_key(object, scene.units, files) + (with_looks ? " with looks" : ""));
            if (!known.meshes.find(keys.back()) && read.insert(keys.back()).second) loader.read(keys.back(), object);
        } catch (const Failure& failure) {
            throw failure.at("object " + object.name);
        }
    }
    loader.finish(scene.threads, [&](const std::string& key, LoadedMesh mesh, std::span<const std::string> notes) {
        known.meshes.add(key, std::move(mesh));
        loaded.notes.insert(loaded.notes.end(), notes.begin(), notes.end());
    });
    for (size_t k = 0; k < objects.size(); ++k) {
        const LoadedMesh& mesh = *known.meshes.find(keys[k]);
        LoadedObject& made =
            loaded.objects.emplace_back(LoadedObject{objects[k], mesh.input, mesh.images, {}, {}, !mesh.fault.empty()});
        if (made.refused) {
            loaded.notes.push_back(note_of(objects[k], mesh.fault));
            fix(made.object);
        }
        place(made, objects[k].placement);
    }
    check_glue(loaded);
    find_home(loaded);
    if (!cache) return loaded;
    std::set<std::string> used{scene.level.mesh};
    for (const LoadedObject& object : loaded.objects) used.insert(object.object.recipe.mesh);
    files.keep_only(used);
    known.meshes.end_round();
    return loaded;
}

Broken break_object(const LoadedObject& loaded, uint32_t threads) {
    const SceneObject& object = loaded.object;
    FractureOptions options = start_options(object);
    options.threads = threads;
    if (!object.in_pieces) return break_input(*loaded.input, options);
    options.world.bonded = false;
    Broken broken = break_input(*loaded.input, options);
    broken.fragments.bonds = must(fracture::find_contacts(broken.fragments, {.tolerance = object.contact_tolerance}));
    return broken;
}

namespace {

PreparedObject prepare_object(const LoadedObject& loaded, const DrawingMaker& payload, uint32_t threads) {
    const SceneObject& object = loaded.object;
    PreparedObject made{.name = object.name,
                        .world = world_of(start_options(object), loaded.input->scale),
                        .material = object.recipe.material,
                        .rigid = !object.recipe.world.breakable,
                        .looks = loaded.input->looks,
                        .placement = loaded.placement};
    made.world.breakable = object.recipe.world.breakable;
    if (object.fixed)
        made.surface = {loaded.input, &loaded.input->model.mesh};
    else
        made.fragments = std::make_shared<const fracture::Fragments>(break_object(loaded, threads).fragments);
    prepare(made, payload, threads);
    return made;
}

// The state of one object while a scene is prepared.
struct Work {
    size_t like = 0; // the object whose solids it shares: itself, or an earlier one
    std::optional<PreparedObject> made{};
    std::string fault{}; // why it cannot be cut, so that it became fixed
};

// An object that turns out not to be breakable only when it is cut, such as one that passes through itself, becomes
// fixed.
void prepare_or_fix(LoadedObject& loaded, const DrawingMaker& payload, uint32_t threads, Work& work) {
    try {
        work.made = prepare_object(loaded, payload, threads);
    } catch (const Failure& failure) {
        if (failure.code() != exit_mesh || loaded.object.fixed) throw;
        work.fault = failure.what();
        fix(loaded.object);
        work.made = prepare_object(loaded, payload, threads);
    }
}

void copy_prepared(const PreparedObject& like, LoadedObject& loaded, Work& work) {
    if (like.fixed() && !loaded.object.fixed) {
        work.fault = "as " + like.name;
        fix(loaded.object);
    }
    PreparedObject& copy = work.made.emplace(copy_of(like));
    copy.name = loaded.object.name;
    copy.placement = loaded.placement;
    copy.world.seed = loaded.object.recipe.pattern.seed;
}

void take_prepared(const PreparedOnce& known, LoadedObject& loaded, const DrawingMaker& payload, Work& work) {
    if (!known.fault.empty()) fix(loaded.object);
    work.fault = known.fault;
    PreparedObject& made = work.made.emplace(copy_of(known.object, payload, 1));
    made.name = loaded.object.name;
    made.placement = loaded.placement;
}

std::vector<Work> work_of(const LoadedScene& scene) {
    std::vector<Work> work;
    std::map<std::pair<const Input*, std::string>, size_t> known;
    for (const LoadedObject& loaded : scene.objects) {
        const auto key = std::pair(loaded.input.get(), solid_key(loaded.object));
        work.push_back({.like = known.try_emplace(key, work.size()).first->second});
    }
    return work;
}

} // namespace

std::vector<PreparedObject> prepare_scene(LoadedScene& scene, const Host& host, const DrawingMaker& payload,
                                          const std::function<void(double)>& progress, SceneCache* cache) {
    std::vector<Work> work = work_of(scene);
    using Key = std::pair<std::shared_ptr<const Input>, std::string>;
    std::vector<Key> keys(work.size()); // of originals
    std::vector<const PreparedOnce*> known(work.size());
    std::vector<size_t> originals, unknown, copies;
    for (size_t k = 0; k < work.size(); ++k) {
        const bool is_original = work[k].like == k;
        (is_original ? originals : copies).push_back(k);
        if (is_original && cache) {
            keys[k] = {scene.objects[k].input, prepared_key(scene.objects[k].object)}; // before it is found unbreakable
            known[k] = cache->prepared.find(keys[k]);
        }
        if (is_original && !known[k]) unknown.push_back(k);
    }
    ObjectLoop loop(scene, host, progress, work.size());
    loop.share_among(unknown);
    loop.run(originals, [&](size_t k) {
        if (known[k]) return take_prepared(*known[k], scene.objects[k], payload, work[k]);
        prepare_or_fix(scene.objects[k], payload, loop.threads_for(k), work[k]);
    });
    if (cache) {
        for (const size_t k : originals)
            if (!known[k]) cache->prepared.add(keys[k], {copy_of(*work[k].made), work[k].fault});
        cache->prepared.end_round();
    }
    loop.run(copies, [&](size_t k) { copy_prepared(*work[work[k].like].made, scene.objects[k], work[k]); });
    std::vector<PreparedObject> objects;
    for (size_t k = 0; k < work.size(); ++k) {
        if (!work[k].fault.empty()) scene.notes.push_back(note_of(scene.objects[k].object, work[k].fault));
        objects.push_back(std::move(*work[k].made));
    }
    const std::vector<std::string> notes = find_glue(scene, objects);
    scene.notes.insert(scene.notes.end(), notes.begin(), notes.end());
    return objects;
}

} // namespace brittle::tools
