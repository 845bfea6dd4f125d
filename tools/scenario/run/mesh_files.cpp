#include "tools/scenario/run/mesh_files.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "fracture/io/text_cursor.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/topology.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/json_reader.h"

namespace brittle::tools {
namespace {

void turn_corners(auto& list) {
    for (size_t t = 0; t + 2 < list.size(); t += 3) std::swap(list[t + 1], list[t + 2]);
}

// The mesh of a node in the coordinates of its file. A mirrored mesh is turned, so that it stays outside out.
fracture::Model placed(const fracture::SceneMesh& from, const glm::dmat4& world) {
    fracture::Model model = from.looks;
    model.mesh = from.mesh;
    for (glm::dvec3& p : model.mesh.positions) p = glm::dvec3(world * glm::dvec4(p, 1.0));
    if (glm::determinant(glm::dmat3(world)) < 0.0)
        for (fracture::Triangle& t : model.mesh.triangles) std::swap(t.y, t.z);
    turn_attributes(model, glm::dmat3(world));
    return model;
}

} // namespace

MeshFiles::Whole& MeshFiles::whole_of(const std::string& file) {
    std::string stamp = stamp_of(file);
    auto at = whole_.find(file);
    if (at == whole_.end() || at->second.stamp != stamp)
        at = whole_.insert_or_assign(file, Whole{std::move(stamp), load_mesh_only(file, true).model, {}}).first;
    return at->second;
}

const fracture::Model& MeshFiles::model_of(const SceneObject& object) {
    const std::string& file = object.recipe.mesh;
    if (object.in_pieces) return pieces_of(file);
    if (object.node.empty()) return whole_of(file).model;
    const Content& content = content_of(file);
    node_ = fracture::model_of(content.scene, mesh_in(content, object));
    return node_;
}

std::shared_ptr<const engine::MaterialSet> MeshFiles::materials_of(const SceneObject& object, const LooksMaker& maker,
                                                                   std::vector<std::string>& notes) {
    if (!maker.materials) return nullptr;
    const std::string& file = object.recipe.mesh;
    const bool is_whole = !object.in_pieces && object.node.empty();
    const fracture::Model& model = model_of(object);
    if (!is_whole && !fracture::has_looks(model)) return nullptr; // nodes of one file differ
    Looks& looks = looks_of(object);
    if (std::exchange(looks.is_decoded, true)) return looks.materials;
    fracture::Model& source = is_whole ? whole_of(file).model : content_of(file).scene.looks;
    std::vector<std::string> own = std::exchange(source.notes, {});
    fracture::Model shown = model;
    shown.images = *looks.images;
    looks.materials = maker.materials(shown, own);
    for (const std::string& note : own) notes.push_back(mesh_name(file) + ": " + note);
    return looks.materials;
}

MeshFiles::Looks& MeshFiles::looks_of(const SceneObject& object) {
    const std::string& file = object.recipe.mesh;
    const bool is_whole = !object.in_pieces && object.node.empty();
    Looks& looks = is_whole ? whole_of(file).looks : content_of(file).looks;
    std::vector<fracture::Image>& images = is_whole ? whole_of(file).model.images : content_of(file).scene.looks.images;
    if (!looks.images) looks.images = std::make_shared<const std::vector<fracture::Image>>(std::exchange(images, {}));
    return looks;
}

std::shared_ptr<const std::vector<fracture::Image>> MeshFiles::images_of(const SceneObject& object) {
    return looks_of(object).images;
}

std::optional<uint32_t> MeshFiles::index_of(const SceneObject& object) {
    if (object.node.empty()) return std::nullopt;
    return mesh_in(content_of(object.recipe.mesh), object);
}

uint32_t MeshFiles::mesh_in(const Content& content, const SceneObject& object) {
    const auto mesh = content.mesh_of.find(object.node);
    if (mesh != content.mesh_of.end()) return mesh->second;
    constexpr size_t max_listed = 10;
    std::string names;
    for (size_t k = 0; k < std::min(max_listed, content.scene.nodes.size()); ++k)
        names += (k > 0 ? ", " : "") + fracture::printable(content.scene.nodes[k].name);
    throw Failure(exit_input, object.recipe.mesh + " has no node " + shown(object.node)
                                  + " that shows a mesh; its nodes are: " + names
                                  + (content.scene.nodes.size() > max_listed ? ", ..." : ""));
}

MeshFiles::Content& MeshFiles::content_of(const std::string& file) {
    std::string stamp = stamp_of(file);
    if (const auto known = nodes_.find(file); known != nodes_.end() && known->second.stamp == stamp)
        return known->second;
    Content content{std::move(stamp), must(fracture::import_scene(file, true)), {}, {}};
    for (const fracture::SceneNode& node : content.scene.nodes) content.mesh_of[node.name] = node.mesh;
    return nodes_.insert_or_assign(file, std::move(content)).first->second;
}

// The meshes of all nodes side by side: points at which pieces touch stay apart. Throws a Failure with exit_mesh that
// names the first node that is no piece.
const fracture::Model& MeshFiles::pieces_of(const std::string& file) {
    std::string stamp = stamp_of(file);
    if (const auto known = pieces_.find(file); known != pieces_.end() && known->second.stamp == stamp)
        return known->second.model;
    const fracture::MeshScene& scene = content_of(file).scene;
    fracture::Model joined;
    joined.materials = scene.looks.materials;
    joined.textures = scene.looks.textures;
    for (const fracture::SceneNode& node : scene.nodes) {
        const fracture::Model piece = placed(scene.meshes[node.mesh], node.world);
        if (const std::string fault = fault_of(piece.mesh); !fault.empty())
            throw Failure(exit_mesh, "the piece " + shown(node.name) + ": " + fault);
        fracture::append_mesh(joined, piece);
    }
    return pieces_.insert_or_assign(file, Pieces{std::move(stamp), std::move(joined)}).first->second.model;
}

void MeshFiles::keep_only(const std::set<std::string>& files) {
    const auto is_left_out = [&](const auto& file) { return !files.contains(file.first); };
    std::erase_if(nodes_, is_left_out);
    std::erase_if(whole_, is_left_out);
    std::erase_if(pieces_, is_left_out);
}

void turn_attributes(fracture::Model& model, const glm::dmat3& linear) {
    const bool mirrored = glm::determinant(linear) < 0.0;
    const glm::dmat3 cofactors(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                               glm::cross(linear[0], linear[1]));
    for (glm::vec3& normal : model.normals) {
        const glm::dvec3 turned = (mirrored ? -1.0 : 1.0) * (cofactors * glm::dvec3(normal));
        const double length = glm::length(turned);
        normal = length > 0.0 ? glm::vec3(turned / length) : glm::vec3(0.0f); // zero: flat
    }
    if (!mirrored) return;
    for (auto& set : model.uv) turn_corners(set);
    turn_corners(model.normals);
    turn_corners(model.colours);
}

std::string fault_of(const fracture::TriangleMesh& mesh) {
    const auto report = fracture::check_topology(mesh.positions.size(), mesh.triangles);
    if (!report.closed()) return fracture::describe(report);
    if (!(fracture::signed_volume(mesh.positions, mesh.triangles) > 0.0))
        return "it encloses no volume, or its triangles face inwards";
    return {};
}

std::string stamp_of(const std::string& file) {
    namespace fs = std::filesystem;
    if (file.empty() || file.starts_with("shape:")) return {};
    std::error_code error;
    const fs::file_time_type changed = fs::last_write_time(file, error);
    if (error) return {};
    const uintmax_t bytes = fs::file_size(file, error);
    return error ? std::string() : std::to_string(changed.time_since_epoch().count()) + " " + std::to_string(bytes);
}

} // namespace brittle::tools
