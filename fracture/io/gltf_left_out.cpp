#include "fracture/io/gltf_left_out.h"

namespace brittle::fracture::gltf {
namespace {

uint64_t size_of(const Json* list) {
    return list != nullptr && list->is_array() ? list->size() : 0;
}

// The member of an extension of an object; null where there is none.
const Json* extension_member(const Json& object, const char* extension, const char* key) {
    const Json* all = member(object, "extensions");
    const Json* one = all != nullptr ? member(*all, extension) : nullptr;
    return one != nullptr ? member(*one, key) : nullptr;
}

// Meshes with each kind of content.
struct MeshCounts {
    uint64_t morph_targets = 0, tangents = 0, further_attributes = 0, points_and_lines = 0;
};

MeshCounts count_meshes(const Json* meshes) {
    MeshCounts counts;
    if (size_of(meshes) == 0) return counts;
    for (const Json& mesh : *meshes) {
        const Json* primitives = member(mesh, "primitives");
        if (size_of(primitives) == 0) continue;
        MeshCounts of_mesh;
        for (const Json& primitive : *primitives) {
            if (size_of(member(primitive, "targets")) > 0) of_mesh.morph_targets = 1;
            if (unsigned_member(primitive, "mode", 4).value_or(4) < 4) of_mesh.points_and_lines = 1;
            const Json* attributes = member(primitive, "attributes");
            if (attributes == nullptr || !attributes->is_object()) continue;
            if (attributes->contains("TANGENT")) of_mesh.tangents = 1;
            // The sets of one kind are numbered without gaps.
            if (attributes->contains("TEXCOORD_2") || attributes->contains("COLOR_1")) of_mesh.further_attributes = 1;
        }
        counts.morph_targets += of_mesh.morph_targets;
        counts.tangents += of_mesh.tangents;
        counts.further_attributes += of_mesh.further_attributes;
        counts.points_and_lines += of_mesh.points_and_lines;
    }
    return counts;
}

uint64_t count_instanced(const Json* nodes) {
    uint64_t count = 0;
    if (size_of(nodes) == 0) return count;
    for (const Json& node : *nodes)
        count += extension_member(node, "EXT_mesh_gpu_instancing", "attributes") != nullptr ? 1 : 0;
    return count;
}

std::string counted(uint64_t count, const char* one, const char* several) {
    return std::to_string(count) + " " + (count == 1 ? one : several);
}

} // namespace

std::string left_out(const Json& document) {
    std::string list;
    const auto add = [&list](uint64_t count, const std::string& text) {
        if (count > 0) list += (list.empty() ? "" : ", ") + text;
    };
    const auto add_list = [&](const Json* values, const char* one, const char* several, const char* more = "") {
        add(size_of(values), counted(size_of(values), one, several) + more);
    };
    const MeshCounts meshes = count_meshes(member(document, "meshes"));
    const auto of_meshes = [&](const char* what, uint64_t count, const char* more = "") {
        add(count, what + std::string(" of ") + counted(count, "mesh", "meshes") + more);
    };
    const uint64_t instanced = count_instanced(member(document, "nodes"));
    add_list(member(document, "skins"), "skin", "skins", " (meshes keep the shape without it)");
    add_list(member(document, "animations"), "animation", "animations");
    of_meshes("morph targets", meshes.morph_targets);
    of_meshes("tangents", meshes.tangents, " (new ones are made for normal maps)");
    of_meshes("further texture coordinates or colours", meshes.further_attributes);
    of_meshes("points or lines", meshes.points_and_lines);
    add(instanced, "instances of " + counted(instanced, "node", "nodes"));
    add_list(member(document, "cameras"), "camera", "cameras");
    add_list(extension_member(document, "KHR_lights_punctual", "lights"), "light", "lights");
    return list.empty() ? list : "left out, because pieces do not keep it: " + list;
}

std::string compression_refusal(const std::string& extension) {
    if (extension != "KHR_draco_mesh_compression" && extension != "EXT_meshopt_compression") return {};
    return "its geometry is compressed with " + extension
           + ", which is not read; "
             "`npx @gltf-transform/cli copy IN.glb OUT.glb` writes the file without this compression";
}

} // namespace brittle::fracture::gltf
