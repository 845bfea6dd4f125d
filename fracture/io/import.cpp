#include "fracture/io/import.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <exception>
#include <initializer_list>
#include <type_traits>
#include <utility>

#include "fracture/io/read_file.h"
#include "fracture/io/readers.h"
#include "fracture/io/text_cursor.h"
#include "fracture/io/weld.h"

namespace brittle::fracture {
namespace {

std::string lower_case(std::string extension) {
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

bool is_importable(const std::string& extension) {
    const std::vector<std::string>& known = importable_extensions();
    return std::find(known.begin(), known.end(), extension) != known.end();
}

Error unsupported(const std::string& name, const std::string& extension) {
    std::string readable;
    for (const std::string& known : importable_extensions()) readable += (readable.empty() ? "" : ", ") + known;
    const std::string what = extension.empty() ? "the file name has no extension" : extension + " files are not read";
    return {Status::unsupported_format, name + ": " + what + "; convert the mesh to one of " + readable};
}

// Returns the text of a file in UTF-8: that of UTF-16 with a byte order mark is converted, `converted` holds it then.
// Only names have characters beyond ASCII; halves of a pair without the other become '?'.
std::string_view utf8_of(std::span<const std::byte> bytes, std::string& converted) {
    const auto byte = [&](size_t k) { return std::to_integer<uint32_t>(bytes[k]); };
    const bool little = bytes.size() >= 2 && byte(0) == 0xff && byte(1) == 0xfe;
    const bool big = bytes.size() >= 2 && byte(0) == 0xfe && byte(1) == 0xff;
    if (!little && !big) return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    const auto unit = [&](size_t k) { return little ? byte(k) | byte(k + 1) << 8 : byte(k) << 8 | byte(k + 1); };
    for (size_t k = 2; k + 1 < bytes.size(); k += 2) {
        uint32_t c = unit(k);
        const bool is_pair =
            c >= 0xd800 && c < 0xdc00 && k + 3 < bytes.size() && unit(k + 2) >= 0xdc00 && unit(k + 2) < 0xe000;
        if (is_pair) {
            c = 0x10000 + ((c - 0xd800) << 10) + (unit(k + 2) - 0xdc00);
            k += 2;
        } else if (c >= 0xd800 && c < 0xe000) {
            c = '?';
        }
        const auto put = [&](uint32_t value) { converted += static_cast<char>(value); };
        if (c < 0x80) {
            put(c);
        } else if (c < 0x800) {
            put(0xc0 | c >> 6);
            put(0x80 | (c & 0x3f));
        } else if (c < 0x10000) {
            put(0xe0 | c >> 12);
            put(0x80 | (c >> 6 & 0x3f));
            put(0x80 | (c & 0x3f));
        } else {
            put(0xf0 | c >> 18);
            put(0x80 | (c >> 12 & 0x3f));
            put(0x80 | (c >> 6 & 0x3f));
            put(0x80 | (c & 0x3f));
        }
    }
    return converted;
}

Result<Model> model_of(Result<TriangleMesh> mesh) {
    if (!mesh) return mesh.error();
    Model model;
    model.mesh = std::move(*mesh);
    return model;
}

Result<void> check_finite(const TriangleMesh& mesh) {
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        const glm::dvec3& p = mesh.positions[v];
        if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) continue;
        char place[96];
        std::snprintf(place, sizeof(place), "(%g, %g, %g)", p.x, p.y, p.z);
        return Error{Status::malformed_file,
                     "vertex " + std::to_string(v) + " lies at " + place + "; all coordinates must be finite"};
    }
    return {};
}

Error named(const std::string& name, const Error& error) {
    return {error.status, name + ": " + error.message};
}

Error no_triangles(const std::string& name) {
    return {Status::empty_mesh, name + ": no triangles in the file; export the mesh with its faces"};
}

Result<Model> read_and_weld(const std::string& name, const std::string& extension, std::span<const std::byte> bytes,
                            Companions& companions) {
    Result<Model> model = read_model(extension, bytes, companions);
    if (!model) return named(name, model.error());
    if (const Result<void> finite = check_finite(model->mesh); !finite) return named(name, finite.error());
    std::vector<uint32_t> kept;
    TriangleMesh welded = weld_surface(model->mesh, model->points, kept);
    model->points.clear();
    if (welded.triangles.empty()) {
        if (model->mesh.triangles.empty()) return no_triangles(name);
        return Error{Status::empty_mesh, name
                                             + ": all triangles in the file have two corners at the same place; "
                                               "export it in a larger unit or with more digits"};
    }
    keep_triangles(*model, std::move(welded), kept);
    return model;
}

Result<Model> import_file(const std::filesystem::path& file, bool with_attributes) {
    const std::string extension = lower_case(file.extension().string());
    if (!is_importable(extension)) return unsupported(file.string(), extension);
    const Result<std::vector<std::byte>> bytes = read_file(file);
    if (!bytes) return bytes.error();
    Companions companions(file.parent_path(), !with_attributes);
    return read_and_weld(file.string(), extension, *bytes, companions);
}

// Returns whether an engine takes the node as a collision shape, by its name: Unreal by the start, Godot by the end.
bool is_collision_shape(const std::string& name) {
    const auto starts = [&](const char* start) { return name.starts_with(start); };
    const auto ends = [&](const char* end) { return name.ends_with(end); };
    return std::ranges::any_of(std::array{"UCX_", "UBX_", "UCP_", "USP_"}, starts)
           || std::ranges::any_of(std::array{"-colonly", "-convcolonly"}, ends);
}

// Welds the meshes, and leaves out the nodes of those without triangles and collision shapes.
Result<MeshScene> weld_scene(RawScene raw) {
    MeshScene scene;
    const size_t all = raw.nodes.size();
    std::erase_if(raw.nodes, [](const SceneNode& node) { return is_collision_shape(node.name); });
    if (const size_t shapes = all - raw.nodes.size(); shapes > 0)
        add_note(scene.notes, std::to_string(shapes)
                                  + (shapes == 1 ? " node that is a collision shape by its name is left out"
                                                 : " nodes that are collision shapes by their names are left out"));
    std::vector<bool> shown(raw.meshes.size());
    for (const SceneNode& node : raw.nodes) shown[node.mesh] = true;
    constexpr uint32_t left_out = ~0u;
    std::vector<uint32_t> number(raw.meshes.size(), left_out); // of each raw mesh in the scene
    for (size_t m = 0; m < raw.meshes.size(); ++m) {
        if (!shown[m]) continue;
        SceneMesh& mesh = raw.meshes[m];
        if (const Result<void> finite = check_finite(mesh.mesh); !finite)
            return named("mesh " + fracture::quoted(mesh.name), finite.error());
        std::vector<uint32_t> kept;
        TriangleMesh welded = weld_surface(mesh.mesh, raw.points[m], kept);
        if (welded.triangles.empty()) continue;
        mesh.looks.mesh = std::move(mesh.mesh);
        keep_triangles(mesh.looks, std::move(welded), kept);
        mesh.mesh = std::exchange(mesh.looks.mesh, {});
        number[m] = static_cast<uint32_t>(scene.meshes.size());
        scene.meshes.push_back(std::move(mesh));
    }
    for (SceneNode& node : raw.nodes) {
        if (number[node.mesh] == left_out) {
            add_note(scene.notes, "node " + fracture::quoted(node.name) + " is left out, as its mesh has no triangles");
            continue;
        }
        node.mesh = number[node.mesh];
        scene.nodes.push_back(std::move(node));
    }
    scene.looks = std::move(raw.looks);
    return scene;
}

Result<MeshScene> import_scene_file(const std::filesystem::path& file, bool with_looks) {
    const std::string name = file.string(), extension = lower_case(file.extension().string());
    if (extension != ".glb" && extension != ".gltf")
        return Error{Status::unsupported_format, name + ": only .glb and .gltf files have nodes; convert the scene"};
    const Result<std::vector<std::byte>> bytes = read_file(file);
    if (!bytes) return bytes.error();
    Companions companions(file.parent_path(), !with_looks);
    Result<RawScene> raw = read_gltf_scene(*bytes, companions);
    if (!raw) return named(name, raw.error());
    Result<MeshScene> scene = weld_scene(std::move(*raw));
    if (!scene) return named(name, scene.error());
    if (scene->nodes.empty()) return no_triangles(name);
    return scene;
}

// The readers do not throw, but allocation and the JSON library do when memory runs out.
template<class Import>
std::invoke_result_t<Import> guarded(const std::filesystem::path& file, const Import& import) {
    try {
        return import();
    } catch (const std::exception& exception) {
        return Error{Status::malformed_file, file.string() + ": cannot be read: " + exception.what()};
    }
}

Result<Model> import(const std::filesystem::path& file, bool with_attributes) {
    return guarded(file, [&] { return import_file(file, with_attributes); });
}

} // namespace

Result<Model> read_model(std::string_view extension, std::span<const std::byte> bytes, Companions& companions) {
    std::string converted;
    if (extension == ".obj") return read_obj(utf8_of(bytes, converted), companions);
    if (extension == ".off") return read_off(utf8_of(bytes, converted));
    if (extension == ".stl") return read_stl(bytes);
    if (extension == ".3ds") return model_of(read_3ds(bytes));
    if (extension == ".ply") return read_ply(bytes, companions);
    return read_gltf(bytes, companions);
}

std::string_view extension_of(std::span<const std::byte> bytes) {
    constexpr size_t max_comment_bytes = size_t{1} << 20; // bytes before the first word of a text
    const auto number = [&](size_t at) {                  // 32 bits, little endian
        uint32_t value = 0;
        for (size_t k = 0; k < 4; ++k) value |= std::to_integer<uint32_t>(bytes[at + k]) << (8 * k);
        return value;
    };
    const std::string_view raw(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (raw.starts_with("glTF")) return ".glb";
    if (raw.starts_with("ply\n") || raw.starts_with("ply\r")) return ".ply";
    if (bytes.size() > 84 && bytes.size() == 84 + 50 * uint64_t{number(80)}) return ".stl";
    if (bytes.size() >= 6 && raw.starts_with("MM") && number(2) >= 6 && number(2) <= bytes.size()) return ".3ds";
    std::string converted;
    TextCursor cursor(utf8_of(bytes.first(std::min(bytes.size(), max_comment_bytes)), converted));
    std::string_view word = cursor.token_of_any_line();
    while (word.starts_with('#')) {
        cursor.next_line();
        word = cursor.token_of_any_line();
    }
    const auto is_one_of = [&](std::initializer_list<std::string_view> words) {
        return std::find(words.begin(), words.end(), word) != words.end();
    };
    if (word.starts_with('{')) return ".gltf";
    if (is_one_of({"OFF", "COFF", "NOFF", "CNOFF"})) return ".off";
    if (lower_case(std::string(word.substr(0, 6))) == "solid") return ".stl";
    if (is_one_of({"v", "vt", "vn", "vp", "f", "l", "p", "o", "g", "s", "mtllib", "usemtl"})) return ".obj";
    return {};
}

const std::vector<std::string>& importable_extensions() {
    static const std::vector<std::string> extensions{".obj", ".stl", ".ply", ".off", ".glb", ".gltf", ".3ds"};
    return extensions;
}

Result<TriangleMesh> import_mesh(const std::filesystem::path& file) {
    Result<Model> model = import(file, false);
    if (!model) return model.error();
    return std::move(model->mesh);
}

Result<Model> import_model(const std::filesystem::path& file) {
    return import(file, true);
}

Result<Model> import_model(std::span<const std::byte> bytes, std::string_view extension, std::string_view name) {
    try {
        const std::string kind = lower_case(std::string(extension));
        if (!is_importable(kind)) return unsupported(std::string(name), kind);
        Companions none{std::nullopt};
        return read_and_weld(std::string(name), kind, bytes, none);
    } catch (const std::exception& exception) {
        return Error{Status::malformed_file, std::string(name) + ": cannot be read: " + exception.what()};
    }
}

Result<MeshScene> import_scene(const std::filesystem::path& file, bool with_looks) {
    return guarded(file, [&] { return import_scene_file(file, with_looks); });
}

Result<Image> read_image(const std::filesystem::path& file) {
    Result<std::vector<std::byte>> bytes = read_file(file);
    if (!bytes) return bytes.error();
    Image image{file.stem().string(), image_type(*bytes)};
    if (image.mime_type.empty())
        return Error{Status::unsupported_format, file.string() + ": not a PNG, JPEG, WebP or KTX2 image"};
    image.bytes = std::move(*bytes);
    return image;
}

} // namespace brittle::fracture
