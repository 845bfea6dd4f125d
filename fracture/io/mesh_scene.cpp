#include "fracture/io/mesh_scene.h"

#include <algorithm>
#include <cstddef>

namespace brittle::fracture {

namespace {

// Appends a complete list to one of `size` entries; either may be empty, in place of `nothing` for each entry.
template<class T>
void append_list(std::vector<T>& list, size_t size, const std::vector<T>& other, size_t other_size, const T& nothing) {
    if (list.empty() && other.empty()) return;
    list.resize(size, nothing);
    list.insert(list.end(), other.begin(), other.end());
    list.resize(size + other_size, nothing);
}

} // namespace

Model model_of(const MeshScene& scene, uint32_t mesh) {
    Model model = scene.meshes[mesh].looks;
    model.mesh = scene.meshes[mesh].mesh;
    model.materials = scene.looks.materials;
    model.textures = scene.looks.textures;
    return model;
}

bool has_looks(const Model& model) {
    return !model.colours.empty()
           || std::ranges::any_of(model.material_of, [](uint32_t material) { return material != no_material; });
}

void append_mesh(Model& model, const Model& other) {
    const size_t size = model.mesh.triangles.size(), added = other.mesh.triangles.size();
    for (size_t set = 0; set < model.uv.size(); ++set)
        append_list(model.uv[set], 3 * size, other.uv[set], 3 * added, glm::vec2(0.0f));
    append_list(model.normals, 3 * size, other.normals, 3 * added, glm::vec3(0.0f));
    append_list(model.colours, 3 * size, other.colours, 3 * added, glm::vec4(1.0f));
    append_list(model.material_of, size, other.material_of, added, no_material);
    const auto base = static_cast<uint32_t>(model.mesh.positions.size());
    model.mesh.positions.insert(model.mesh.positions.end(), other.mesh.positions.begin(), other.mesh.positions.end());
    for (const Triangle& t : other.mesh.triangles) model.mesh.triangles.push_back(t + base);
}

} // namespace brittle::fracture
