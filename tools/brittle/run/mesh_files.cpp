#include "tools/brittle/run/mesh_files.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "fracture/io/text_cursor.h"
#include "tools/brittle/base/failure.h"
#include "tools/brittle/recipe/json_reader.h"

namespace brittle::tools {

const fracture::TriangleMesh& MeshFiles::mesh_of(const SceneObject& object) {
    const std::string& file = object.recipe.mesh;
    if (!object.node.empty()) {
        const Content& content = content_of(file);
        return content.scene.meshes[mesh_in(content, object)].mesh;
    }
    std::string stamp = stamp_of(file);
    auto at = whole_.find(file);
    if (at == whole_.end() || at->second.stamp != stamp)
        at = whole_.insert_or_assign(file, Whole{std::move(stamp), load_mesh_only(file).model.mesh}).first;
    return at->second.mesh;
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

const MeshFiles::Content& MeshFiles::content_of(const std::string& file) {
    std::string stamp = stamp_of(file);
    if (const auto known = nodes_.find(file); known != nodes_.end() && known->second.stamp == stamp)
        return known->second;
    Content content{std::move(stamp), must(fracture::import_scene(file)), {}};
    for (const fracture::SceneNode& node : content.scene.nodes) content.mesh_of[node.name] = node.mesh;
    return nodes_.insert_or_assign(file, std::move(content)).first->second;
}

void MeshFiles::keep_only(const std::set<std::string>& files) {
    const auto is_left_out = [&](const auto& file) { return !files.contains(file.first); };
    std::erase_if(nodes_, is_left_out);
    std::erase_if(whole_, is_left_out);
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
