#include "tools/brittle/studio/object.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/mesh/topology.h"
#include "tools/brittle/base/failure.h"
#include "tools/brittle/run/stage.h"

namespace brittle::tools {

namespace {

// M, distance behind a hit at which a ray continues, so that it does not find the hit again.
constexpr double nudge = 1e-6;

std::vector<uint32_t> all_triangles(const fracture::TriangleMesh& mesh) {
    std::vector<uint32_t> all(mesh.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

// The meshes of all objects, in the world.
Input joined(const LoadedScene& scene) {
    Input all;
    all.name = "scene";
    all.units = LengthUnit::metre;
    fracture::TriangleMesh& mesh = all.model.mesh;
    for (const LoadedObject& object : scene.objects) {
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        for (const glm::dvec3& p : object.input->model.mesh.positions)
            mesh.positions.push_back(glm::dvec3(object.placement.position)
                                     + glm::dquat(object.placement.orientation) * p);
        for (const fracture::Triangle& t : object.input->model.mesh.triangles) mesh.triangles.push_back(t + first);
    }
    return all;
}

} // namespace

std::shared_ptr<const Object> Object::load(const FractureOptions& options,
                                           const std::function<void(double)>& progress) {
    if (tools::is_scene(options)) {
        LoadedScene scene = load_scene(options);
        std::vector<PreparedObject> parts = prepare_scene(scene, {}, progress);
        return std::shared_ptr<const Object>(new Object(std::move(scene), std::move(parts)));
    }
    Input input = load_mesh_only(options.mesh);
    input.units = options.units;
    prepare_mesh(options, input);
    const auto report = fracture::check_topology(input.model.mesh.positions.size(), input.model.mesh.triangles);
    if (!report.closed()) throw Failure(exit_mesh, input.name + ": " + fracture::describe(report));
    std::string overlap = options.unite ? std::string() : overlap_of(input.model.mesh);
    return std::shared_ptr<const Object>(new Object(std::move(input), std::move(overlap), options.world));
}

std::shared_ptr<const Object> Object::placed_for(const WorldOptions& world) const {
    return std::shared_ptr<const Object>(new Object(file_, overlap_, world));
}

Object::Object(Input file, std::string overlap, const WorldOptions& world)
    : file_(std::move(file)), stage_(placed_on_stage(file_, world)), overlap_(std::move(overlap)), world_(world),
      placement_(placement_on_stage(file_.model.mesh, world, file_.units)),
      tree_(stage_.model.mesh, all_triangles(stage_.model.mesh)), batch_(batch_of(stage_.model.mesh)),
      home_(fracture::bounds(stage_.model.mesh)) {}

Object::Object(LoadedScene scene, std::vector<PreparedObject> parts)
    : file_(joined(scene)), stage_(file_), world_(scene.world),
      tree_(stage_.model.mesh, all_triangles(stage_.model.mesh)), home_(scene.home), scene_(std::move(scene)),
      parts_(std::move(parts)) {}

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

} // namespace brittle::tools
