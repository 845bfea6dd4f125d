#include "tools/brittle/studio/object.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/mesh/topology.h"
#include "tools/brittle/stage/loading.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/run/scene_glue.h"

namespace brittle::tools {

namespace {

// M, distance behind a hit at which a ray continues, so that it does not find the hit again.
constexpr double nudge = 1e-6;

std::vector<uint32_t> all_triangles(const fracture::TriangleMesh& mesh) {
    std::vector<uint32_t> all(mesh.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

// A host that is also cancelled by a question.
Host cancelled_by(Host host, const std::function<bool()>& question) {
    if (question) host.cancelled = [also = host.cancelled, question] { return question() || (also && also()); };
    return host;
}

// A scene has no mesh of its own.
Input no_mesh() {
    Input none;
    none.name = "scene";
    none.units = LengthUnit::metre;
    return none;
}

// Equal for scenes that differ in the places of their objects alone.
std::string all_but_places(const FractureOptions& options) {
    FractureOptions scene;
    scene.units = options.units;
    scene.piece_scale = options.piece_scale;
    scene.objects = options.objects;
    scene.glue = options.glue;
    for (SceneObject& object : scene.objects) {
        object.placement.translation = glm::dvec3(0.0);
        object.placement.rotation = glm::dvec3(0.0);
    }
    return recipe_json(scene);
}

} // namespace

std::shared_ptr<Object> Object::load_scene(const FractureOptions& options, const Host& host, const Object* earlier,
                                           const Prepare& prepare) {
    auto cache = earlier && earlier->cache_ ? earlier->cache_ : std::make_shared<SceneCache>();
    LoadedScene scene = open_scene(options, host, cache.get(), true);
    std::vector<PreparedObject> parts = prepare ? prepare(scene, *cache) : std::vector<PreparedObject>();
    const std::shared_ptr<Object> made(new Object(std::move(scene), std::move(parts)));
    made->cache_ = std::move(cache);
    made->but_places_ = all_but_places(options);
    for (const LoadedObject& object : made->scene_->objects) made->turned_.push_back(object.object.placement.rotation);
    return made;
}

std::shared_ptr<const Object> Object::open(const FractureOptions& options, const std::function<bool()>& cancelled) {
    if (!tools::is_scene(options)) return load(options, {}, nullptr, cancelled);
    std::shared_ptr<Object> made = load_scene(options, cancelled_by(drawing_host(), cancelled), nullptr, {});
    made->meshes_ = meshes_of(*made->scene_);
    return made;
}

std::shared_ptr<const Object> Object::load(const FractureOptions& options, const std::function<void(double)>& progress,
                                           const Object* earlier, const std::function<bool()>& cancelled) {
    if (tools::is_scene(options)) {
        const Host host = cancelled_by(drawing_host(), cancelled);
        return load_scene(options, host, earlier, [&](LoadedScene& scene, SceneCache& cache) {
            return prepare_scene(scene, host, {}, progress, &cache);
        });
    }
    Input input = load_mesh_only(options.mesh, true);
    input.units = options.units;
    const Host host = cancelled_by(program_host(), cancelled);
    throw_if_cancelled(host);
    prepare_mesh(options, input, host);
    const auto report = fracture::check_topology(input.model.mesh.positions.size(), input.model.mesh.triangles);
    if (!report.closed()) throw Failure(exit_mesh, input.name + ": " + fracture::describe(report));
    std::string overlap = options.unite ? std::string() : overlap_of(input.model.mesh);
    std::vector<std::string> notes = std::move(input.model.notes);
    const std::optional<fracture::Image> cuts = interior_image(options.picture);
    auto materials = materials_of(input.model, notes, cuts ? &*cuts : nullptr);
    input.model.images.clear(); // decoded; an export reads the file again
    const std::shared_ptr<Object> made(
        new Object(std::move(input), std::move(overlap), options.world, std::move(materials)));
    made->look_notes_ = std::move(notes);
    return made;
}

std::shared_ptr<const Object> Object::placed_for(const WorldOptions& world) const {
    const std::shared_ptr<Object> made(new Object(file_, overlap_, world, materials_));
    made->look_notes_ = look_notes_;
    return made;
}

namespace {

// The mesh on the stage with its looks, and without the attributes that they are made from.
Input on_stage(const Input& file, const WorldOptions& world, std::shared_ptr<const engine::MaterialSet> materials) {
    Input input = placed_on_stage(file, world);
    input.looks = looks_of(input.model, input.model.mesh, std::move(materials));
    keep_mesh_only(input.model);
    return input;
}

} // namespace

Object::Object(Input file, std::string overlap, const WorldOptions& world,
               std::shared_ptr<const engine::MaterialSet> materials)
    : file_(std::move(file)), stage_(on_stage(file_, world, materials)), overlap_(std::move(overlap)),
      materials_(std::move(materials)), world_(world),
      placement_(placement_on_stage(file_.model.mesh, world, file_.units)),
      tree_(stage_.model.mesh, all_triangles(stage_.model.mesh)),
      batch_(batch_of(stage_.model.mesh, stage_.looks.get())), home_(fracture::bounds(stage_.model.mesh)),
      extent_(fracture::bounds(file_.model.mesh)), triangles_(stage_.model.mesh.triangles.size()) {}

Object::Object(LoadedScene scene, std::vector<PreparedObject> parts)
    : file_(no_mesh()), stage_(file_), world_(scene.world), tree_(stage_.model.mesh, {}), home_(scene.home),
      extent_(scene.objects.front().box), scene_(std::move(scene)), parts_(std::move(parts)) {
    for (const LoadedObject& object : scene_->objects) {
        extent_ = {glm::min(extent_.min, object.box.min), glm::max(extent_.max, object.box.max)};
        triangles_ += object.input->model.mesh.triangles.size();
    }
}

std::shared_ptr<const Object> Object::placed_as(const FractureOptions& options) const {
    if (!scene_ || all_but_places(options) != but_places_) return nullptr;
    LoadedScene scene = *scene_;
    std::vector<PreparedObject> parts;
    for (size_t k = 0; k < scene.objects.size(); ++k) {
        if (scene.objects[k].object.placement != options.objects[k].placement)
            place(scene.objects[k], options.objects[k].placement);
        if (parts_.empty()) continue;
        parts.push_back(copy_of(parts_[k], {}, 1));
        parts.back().placement = scene.objects[k].placement;
    }
    find_home(scene);
    const std::shared_ptr<Object> made(new Object(std::move(scene), std::move(parts)));
    made->cache_ = cache_;
    made->but_places_ = but_places_;
    made->turned_ = turned_;
    made->meshes_ = meshes_;
    for (size_t k = 0; k < made->meshes_.objects.size(); ++k)
        made->meshes_.objects[k].placement = made->scene_->objects[k].placement;
    return made;
}

bool Object::is_prepared() const {
    if (!scene_) return true;
    if (parts_.empty()) return false;
    for (size_t k = 0; k < turned_.size(); ++k) {
        const SceneObject& object = scene_->objects[k].object;
        if (object.recipe.world.anchored && object.placement.rotation != turned_[k]) return false;
    }
    return true;
}

std::optional<uint32_t> Object::object_along(const glm::dvec3& from, const glm::dvec3& direction,
                                             const std::function<bool(uint32_t object)>& skips) const {
    std::optional<uint32_t> first;
    double nearest = std::numeric_limits<double>::infinity();
    for (uint32_t k = 0; k < scene_->objects.size(); ++k) {
        if (skips(k)) continue;
        const physics::Pose& at = scene_->objects[k].placement;
        const glm::dquat back = glm::conjugate(glm::dquat(at.orientation));
        const fracture::TriangleMesh& mesh = scene_->objects[k].input->model.mesh;
        const auto hit = fracture::first_hit(mesh.positions, mesh.triangles, back * (from - glm::dvec3(at.position)),
                                             back * direction);
        if (!hit || *hit >= nearest) continue;
        nearest = *hit;
        first = k;
    }
    return first;
}

SiteSet Object::sites(const FractureOptions& options) const {
    SiteSet set = sites_for(options, file_.model.mesh);
    // Only the box decides the placement.
    const fracture::Box box = fracture::bounds(file_.model.mesh);
    Input probe;
    probe.units = file_.units;
    probe.model.mesh.positions = {box.min, box.max};
    probe.sites = std::move(set.sites);
    probe.weights = std::move(set.weights);
    probe = placed_on_stage(std::move(probe), world_);
    return {std::move(probe.sites), std::move(set.groups), std::move(probe.weights)};
}

Input Object::with_sites(const FractureOptions& options) const {
    Input input = stage_;
    SiteSet set = sites(options);
    input.sites = std::move(set.sites);
    input.groups = std::move(set.groups);
    input.weights = std::move(set.weights);
    return input;
}

std::optional<Hit> Object::first_hit(const glm::dvec3& from, const glm::dvec3& direction) const {
    const std::optional<double> distance = tree_.first_hit(from, direction, fracture::no_index);
    if (!distance) return std::nullopt;
    return Hit{from + *distance * direction, *distance};
}

Hit Object::exit_after(const Hit& hit, const glm::dvec3& direction) const {
    const std::optional<Hit> next = first_hit(hit.point + nudge * direction, direction);
    return next ? Hit{next->point, hit.distance + nudge + next->distance} : hit;
}

std::vector<PreparedObject> parts_of(const Object& object, const engine::Renderer& renderer, uint32_t threads) {
    const DrawingMaker payload = payload_maker(renderer);
    std::vector<PreparedObject> parts;
    for (const PreparedObject& part : object.parts()) parts.push_back(copy_of(part, payload, threads));
    if (object.is_scene()) (void)find_glue(object.scene(), parts);
    return parts;
}

} // namespace brittle::tools
