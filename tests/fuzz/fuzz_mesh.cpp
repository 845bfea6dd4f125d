// Fuzzes the reader of one mesh format, chosen by FUZZ_FORMAT.
#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "fracture/io/readers.h"
#include "fracture/io/weld.h"
#include "tests/fuzz/oracle.h"

using namespace brittle;
using namespace brittle::fracture;

namespace {

constexpr std::string_view format = FUZZ_FORMAT;

Result<Model> read(std::span<const std::byte> bytes) {
    Companions companions(BRITTLE_CORPUS "/meshes"); // the files that an input may refer to
    if constexpr (format != "mtl") return read_model("." FUZZ_FORMAT, bytes, companions);
    Model model;
    read_mtl({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, companions, model);
    return model;
}

void check_indices(const TriangleMesh& mesh) {
    for (const Triangle& t : mesh.triangles)
        fuzz::require(std::max({t.x, t.y, t.z}) < mesh.positions.size(), "a triangle names a vertex that is not there");
}

// Attribute lists are complete or empty, and all indices are valid.
void check_looks(const Model& model) {
    const size_t triangles = model.mesh.triangles.size();
    const auto check_size = [](size_t size, size_t whole) {
        fuzz::require(size == 0 || size == whole, "a list of looks is too long or too short");
    };
    for (const auto& set : model.uv) check_size(set.size(), 3 * triangles);
    check_size(model.normals.size(), 3 * triangles);
    check_size(model.colours.size(), 3 * triangles);
    check_size(model.material_of.size(), triangles);
    for (const uint32_t m : model.material_of)
        fuzz::require(m == no_material || m < model.materials.size(), "a triangle names no material");
    for (const Material& m : model.materials) {
        for (const auto& use : {m.base_colour_texture, m.metallic_roughness_texture, m.normal_texture,
                                m.occlusion_texture, m.emissive_texture}) {
            fuzz::require(!use || (use->texture < model.textures.size() && use->uv_set < model.uv.size()),
                          "a material names no texture");
        }
    }
    for (const Texture& t : model.textures)
        fuzz::require(!t.image || *t.image < model.images.size(), "a texture names no image");
    for (const std::string& note : model.notes) fuzz::check_message(note);
}

// The same file, node by node.
void check_scene(std::span<const std::byte> bytes) {
    Companions companions(BRITTLE_CORPUS "/meshes");
    const Result<RawScene> scene = read_gltf_scene(bytes, companions);
    if (!scene) return fuzz::check_message(scene.error().message);
    for (const SceneMesh& mesh : scene->meshes) {
        check_indices(mesh.mesh);
        Model model = mesh.looks;
        model.mesh = mesh.mesh;
        model.materials = scene->looks.materials;
        model.textures = scene->looks.textures;
        model.images = scene->looks.images;
        check_looks(model);
    }
    for (const std::string& note : scene->looks.notes) fuzz::check_message(note);
    std::set<std::string> names;
    for (const SceneNode& node : scene->nodes) {
        fuzz::require(node.mesh < scene->meshes.size(), "a node names no mesh");
        fuzz::require(names.insert(node.name).second, "two nodes have one name");
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const fuzz::TimeGuard guard;
    if (format == "gltf") check_scene(std::as_bytes(std::span(data, size)));
    const Result<Model> model = read(std::as_bytes(std::span(data, size)));
    if (!model) {
        fuzz::check_message(model.error().message);
        return 0;
    }
    const TriangleMesh& mesh = model->mesh;
    check_indices(mesh);
    check_looks(*model);
    // A vertex or a corner takes at least one byte, but glTF nodes may use one mesh many times.
    if (format != "gltf") {
        fuzz::require(mesh.positions.size() <= size && mesh.triangles.size() <= size, "more comes out than goes in");
    }
    const bool finite = std::all_of(mesh.positions.begin(), mesh.positions.end(), [](const glm::dvec3& p) {
        return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
    });
    if (finite) check_indices(weld(mesh)); // as in import_model()
    return 0;
}
