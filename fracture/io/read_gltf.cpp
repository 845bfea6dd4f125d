#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>

#include "fracture/io/gltf_document.h"
#include "fracture/io/gltf_left_out.h"
#include "fracture/io/gltf_materials.h"
#include "fracture/io/readers.h"
#include "fracture/io/text_cursor.h"

namespace brittle::fracture {
namespace gltf {
namespace {

// The attributes of the vertices of one primitive.
struct Vertices {
    uint32_t base; // the index of the first one in the mesh
    const glm::dmat4& world;
    const Accessor& positions;
    std::array<std::optional<Accessor>, 2> uv{};
    std::optional<Accessor> normals{}, colours{};
    bool has_opacity = false;
};

// Numbers names that are taken: "Vase", "Vase 2", "Vase 3".
class UniqueNames {
  public:
    std::string take(const std::string& name) {
        std::string unique = name;
        for (uint64_t& number = last_[name]; !taken_.insert(unique).second;)
            unique = name + " " + std::to_string(number = std::max<uint64_t>(number + 1, 2));
        return unique;
    }

  private:
    std::set<std::string> taken_;
    std::map<std::string, uint64_t> last_; // by name
};

class GltfReader {
  public:
    explicit GltfReader(Document& document)
        : document_(document), wants_attributes_(document.companions().wants_attributes()) {}

    Result<Model> read() {
        if (Result<void> done = check_extensions(); !done) return done.error();
        if (wants_attributes_) {
            read_materials(document_, model_);
            if (std::string note = left_out(document_.json()); !note.empty()) add_note(model_.notes, std::move(note));
        }
        const auto add = [&](const Json&, uint64_t, std::optional<uint64_t> mesh, const glm::dmat4& world) {
            return read_mesh(mesh, world);
        };
        if (Result<void> done = visit_mesh_nodes(add); !done) return done.error();
        complete_corners(model_);
        if (!model_.points.empty()) model_.points.resize(model_.mesh.positions.size(), 0);
        return std::move(model_);
    }

    Result<RawScene> read_scene() {
        if (Result<void> done = check_extensions(); !done) return done.error();
        if (wants_attributes_) read_materials(document_, model_);
        RawScene scene;
        std::map<uint64_t, uint32_t> meshes; // index in the scene by that in the file
        UniqueNames names;
        const auto add = [&](const Json& node, uint64_t index, std::optional<uint64_t> mesh,
                             const glm::dmat4& world) -> Result<void> {
            const Result<const Json*> json = document_.element("meshes", mesh);
            if (!json) return json.error();
            const auto [at, is_new] = meshes.try_emplace(*mesh, static_cast<uint32_t>(scene.meshes.size()));
            if (is_new) {
                if (Result<void> done = read_mesh(mesh, glm::dmat4(1.0)); !done) return done;
                take_mesh(**json, scene);
            }
            for (int k = 0; k < 16; ++k)
                if (!std::isfinite(world[k / 4][k % 4]))
                    return malformed(name_of("nodes", index) + " has a transform that is not finite");
            std::string name = text_member(node, "name");
            if (name.empty()) name = scene.meshes[at->second].name;
            if (name.empty()) name = "node " + std::to_string(index);
            scene.nodes.push_back({names.take(name), at->second, world, extras_of(node)});
            return {};
        };
        if (Result<void> done = visit_mesh_nodes(add); !done) return done.error();
        scene.looks = std::move(model_); // what no mesh took
        return scene;
    }

  private:
    static std::string text_member(const Json& object, const char* key) {
        const Json* value = member(object, key);
        return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
    }

    static std::string extras_of(const Json& object) {
        const Json* extras = member(object, "extras");
        return extras != nullptr ? extras->dump() : std::string();
    }

    // Moves the mesh that was read to the scene. The limits go on counting it.
    void take_mesh(const Json& json, RawScene& scene) {
        SceneMesh& mesh = scene.meshes.emplace_back(SceneMesh{.name = text_member(json, "name")});
        vertices_taken_ += model_.mesh.positions.size();
        triangles_taken_ += model_.mesh.triangles.size();
        if (!model_.points.empty()) model_.points.resize(model_.mesh.positions.size(), 0);
        complete_corners(model_);
        for (size_t set = 0; set < model_.uv.size(); ++set) mesh.looks.uv[set] = std::exchange(model_.uv[set], {});
        mesh.looks.normals = std::exchange(model_.normals, {});
        mesh.looks.colours = std::exchange(model_.colours, {});
        mesh.looks.material_of = std::exchange(model_.material_of, {});
        mesh.mesh = std::exchange(model_.mesh, {});
        scene.points.push_back(std::exchange(model_.points, {}));
        mesh.extras = extras_of(json);
        const Json* primitives = member(json, "primitives");
        if (primitives == nullptr) return;
        for (const Json& primitive : *primitives) {
            const Result<const Json*> material =
                document_.element("materials", unsigned_member(primitive, "material", std::nullopt));
            const std::string name = material ? text_member(**material, "name") : std::string();
            if (!name.empty() && std::ranges::find(mesh.materials, name) == mesh.materials.end())
                mesh.materials.push_back(name);
        }
    }

    // A required extension may change the meaning of geometry. Only extensions that cannot are accepted.
    Result<void> check_extensions() const {
        const Json* required = member(document_.json(), "extensionsRequired");
        if (required == nullptr) return {};
        for (const Json& entry : *required) {
            const std::string name = entry.is_string() ? entry.get<std::string>() : entry.dump();
            const bool harmless = name == "KHR_mesh_quantization" || name.starts_with("KHR_materials_")
                                  || name.starts_with("KHR_texture_") || name.starts_with("EXT_texture_")
                                  || name.starts_with("KHR_lights_");
            if (harmless) continue;
            if (const std::string refusal = compression_refusal(name); !refusal.empty()) return malformed(refusal);
            return malformed("needs the glTF extension " + printable(name)
                             + ", which is not read; export without compression and extensions");
        }
        return {};
    }

    Result<std::vector<uint64_t>> root_nodes() const {
        const Json* nodes = member(document_.json(), "nodes");
        const size_t count = nodes != nullptr && nodes->is_array() ? nodes->size() : 0;
        if (member(document_.json(), "scenes") != nullptr) {
            const Result<const Json*> scene =
                document_.element("scenes", unsigned_member(document_.json(), "scene", 0));
            if (!scene) return scene.error();
            return indices_of(**scene, "nodes");
        }
        // Without a scene: all nodes that are not a child.
        std::vector<bool> is_child(count, false);
        for (size_t n = 0; n < count; ++n) {
            const Result<std::vector<uint64_t>> children = indices_of((*nodes)[n], "children");
            if (!children) return children.error();
            for (const uint64_t child : *children) {
                if (child < count) is_child[child] = true;
            }
        }
        std::vector<uint64_t> roots;
        for (size_t n = 0; n < count; ++n) {
            if (!is_child[n]) roots.push_back(n);
        }
        return roots;
    }

    static Result<std::vector<uint64_t>> indices_of(const Json& object, const char* key) {
        std::vector<uint64_t> result;
        const Json* values = member(object, key);
        if (values == nullptr) return result;
        for (const Json& value : *values) {
            if (!value.is_number_unsigned())
                return malformed(std::string(key) + " contains a value that is not an index");
            result.push_back(value.get<uint64_t>());
        }
        return result;
    }

    // Calls visit(node, index, mesh, world) for the nodes of the default scene with a mesh: depth first, in file order,
    // without recursion, as chains of nodes can be as long as the file.
    template<class Visitor>
    Result<void> visit_mesh_nodes(const Visitor& visit_node) {
        const Result<std::vector<uint64_t>> roots = root_nodes();
        if (!roots) return roots.error();
        struct Visit {
            uint64_t node;
            glm::dmat4 parent;
        };
        std::vector<Visit> stack;
        for (auto root = roots->rbegin(); root != roots->rend(); ++root) stack.push_back({*root, glm::dmat4(1.0)});
        std::vector<bool> seen(member(document_.json(), "nodes") != nullptr ? document_.json()["nodes"].size() : 0,
                               false);
        while (!stack.empty()) {
            const Visit visit = stack.back();
            stack.pop_back();
            const Result<const Json*> node = document_.element("nodes", visit.node);
            if (!node) return node.error();
            if (seen[visit.node]) {
                return malformed(name_of("nodes", visit.node) + " is reached twice; nodes must form trees");
            }
            seen[visit.node] = true;

            const Result<glm::dmat4> local = transform_of(**node, visit.node);
            if (!local) return local.error();
            const glm::dmat4 world = visit.parent * *local;
            if (member(**node, "mesh") != nullptr) {
                const std::optional<uint64_t> mesh = unsigned_member(**node, "mesh", std::nullopt);
                if (Result<void> done = visit_node(**node, visit.node, mesh, world); !done) return done;
            }
            const Result<std::vector<uint64_t>> children = indices_of(**node, "children");
            if (!children) return children.error();
            for (auto child = children->rbegin(); child != children->rend(); ++child) stack.push_back({*child, world});
        }
        return {};
    }

    static Result<glm::dmat4> transform_of(const Json& node, uint64_t index) {
        const auto matrix = numbers<16>(node, "matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
        const auto t = numbers<3>(node, "translation", {0, 0, 0});
        const auto r = numbers<4>(node, "rotation", {0, 0, 0, 1});
        const auto s = numbers<3>(node, "scale", {1, 1, 1});
        if (!matrix || !t || !r || !s) return malformed(name_of("nodes", index) + " has a damaged transform");
        if (member(node, "matrix") != nullptr) {
            glm::dmat4 result;
            for (int k = 0; k < 16; ++k) result[k / 4][k % 4] = (*matrix)[static_cast<size_t>(k)];
            return result;
        }
        const glm::dquat rotation((*r)[3], (*r)[0], (*r)[1], (*r)[2]);
        glm::dmat4 result(glm::mat3_cast(rotation) * glm::dmat3((*s)[0], 0, 0, 0, (*s)[1], 0, 0, 0, (*s)[2]));
        result[3] = glm::dvec4((*t)[0], (*t)[1], (*t)[2], 1.0);
        return result;
    }

    Result<void> read_mesh(std::optional<uint64_t> index, const glm::dmat4& world) {
        const Result<const Json*> mesh = document_.element("meshes", index);
        if (!mesh) return mesh.error();
        const Json* primitives = member(**mesh, "primitives");
        if (primitives == nullptr) return {};
        uint64_t number = 0;
        for (const Json& primitive : *primitives) {
            const Result<void> done = read_primitive(primitive, world);
            if (!done) {
                return malformed(name_of("meshes", *index) + "." + name_of("primitives", number) + ": "
                                 + done.error().message);
            }
            ++number;
        }
        return {};
    }

    static bool is_draco(const Json& primitive) {
        const Json* extensions = member(primitive, "extensions");
        return extensions != nullptr && member(*extensions, "KHR_draco_mesh_compression") != nullptr;
    }

    Result<void> read_primitive(const Json& primitive, const glm::dmat4& world) {
        const std::optional<uint64_t> mode = unsigned_member(primitive, "mode", 4);
        if (!mode || *mode > 6) return malformed("its mode is not one of 0 to 6");
        const Json* attributes = member(primitive, "attributes");
        if (*mode < 4 || attributes == nullptr || member(*attributes, "POSITION") == nullptr) return {};

        const Result<Accessor> positions =
            document_.accessor(unsigned_member(*attributes, "POSITION", std::nullopt), "VEC3");
        if (!positions) return positions.error();
        if (positions->data.empty() && is_draco(primitive))
            return malformed(compression_refusal("KHR_draco_mesh_compression")); // not required, yet without a fallback
        std::vector<uint32_t> corners;
        if (member(primitive, "indices") != nullptr) {
            const Result<Accessor> indices =
                document_.accessor(unsigned_member(primitive, "indices", std::nullopt), "SCALAR");
            if (!indices) return indices.error();
            const uint32_t type = indices->component_type;
            if ((type != 5121 && type != 5123 && type != 5125) || indices->normalized)
                return malformed("its indices are not unsigned integers");
            for (uint64_t k = 0; k < indices->count; ++k) {
                const double corner = indices->component(k, 0);
                if (!(corner >= 0.0 && corner < static_cast<double>(positions->count))) {
                    return malformed("index " + std::to_string(k) + " names vertex "
                                     + std::to_string(static_cast<int64_t>(corner)) + " of "
                                     + std::to_string(positions->count));
                }
                corners.push_back(static_cast<uint32_t>(corner));
            }
        } else {
            corners.resize(positions->count);
            for (uint32_t k = 0; k < corners.size(); ++k) corners[k] = k;
        }
        const uint64_t most = std::min(max_elements, free_elements + elements_per_byte * document_.size());
        if (vertices_taken_ + model_.mesh.positions.size() + positions->count > most
            || triangles_taken_ + model_.mesh.triangles.size() + corners.size() > most) {
            return malformed("with it the nodes of the file show over " + std::to_string(most)
                             + " vertices or triangles, the limit for a file of its size; simplify the mesh");
        }
        Vertices vertices{static_cast<uint32_t>(model_.mesh.positions.size()), world, *positions};
        read_points(*attributes, vertices);
        uint32_t material = no_material;
        if (wants_attributes_) {
            read_vertex_attributes(*attributes, vertices);
            const auto named = unsigned_member(primitive, "material", no_material);
            if (named && *named < model_.materials.size()) material = static_cast<uint32_t>(*named);
        }
        return append(vertices, corners, *mode, material);
    }

    // The numbers that write_glb gives the vertices of parts that touch. Vertices without a number have 0.
    void read_points(const Json& attributes, const Vertices& vertices) {
        if (member(attributes, "_POINT") == nullptr) return;
        const Result<Accessor> points = document_.accessor(unsigned_member(attributes, "_POINT", std::nullopt), "VEC2");
        constexpr uint32_t unsigned_short = 5123;
        if (!points || points->count != vertices.positions.count || points->component_type != unsigned_short
            || points->normalized)
            return;
        model_.points.resize(vertices.base, 0);
        for (uint64_t v = 0; v < points->count; ++v)
            model_.points.push_back(1 + static_cast<uint32_t>(points->component(v, 0))
                                    + (static_cast<uint32_t>(points->component(v, 1)) << 16));
    }

    // Faulty attributes are omitted, with a note.
    void read_vertex_attributes(const Json& attributes, Vertices& vertices) {
        const auto find = [&](const char* name,
                              std::initializer_list<std::string_view> types) -> std::optional<Accessor> {
            if (member(attributes, name) == nullptr) return std::nullopt;
            for (const std::string_view type : types) {
                const Result<Accessor> found =
                    document_.accessor(unsigned_member(attributes, name, std::nullopt), type);
                if (found && found->count == vertices.positions.count) return *found;
            }
            add_note(model_.notes, std::string(name) + " of a primitive cannot be read and is left out");
            return std::nullopt;
        };
        vertices.normals = find("NORMAL", {"VEC3"});
        vertices.uv = {find("TEXCOORD_0", {"VEC2"}), find("TEXCOORD_1", {"VEC2"})};
        vertices.colours = find("COLOR_0", {"VEC4", "VEC3"});
        if (!vertices.colours) return;
        const auto colours = document_.element("accessors", unsigned_member(attributes, "COLOR_0", std::nullopt));
        vertices.has_opacity = text_member(**colours, "type") == "VEC4";
    }

    Result<void> append(const Vertices& vertices, const std::vector<uint32_t>& corners, uint64_t mode,
                        uint32_t material) {
        for (uint64_t v = 0; v < vertices.positions.count; ++v) {
            const glm::dvec4 local(vertices.positions.component(v, 0), vertices.positions.component(v, 1),
                                   vertices.positions.component(v, 2), 1.0);
            model_.mesh.positions.emplace_back(vertices.world * local);
        }
        // A mirroring transform turns every triangle inside out (section 3.7.4).
        const bool mirrored = glm::determinant(glm::dmat3(vertices.world)) < 0.0;
        const glm::dmat3 of_normals = normal_matrix(vertices.world);
        const auto add = [&](size_t a, size_t b, size_t c) {
            if (mirrored) std::swap(b, c);
            const Triangle local(corners[a], corners[b], corners[c]);
            if (!wants_attributes_) return model_.mesh.triangles.push_back(local + vertices.base);
            append_triangle(model_, local + vertices.base, material,
                            std::array{attributes_of(vertices, local.x, of_normals),
                                       attributes_of(vertices, local.y, of_normals),
                                       attributes_of(vertices, local.z, of_normals)});
        };
        if (mode == 4) {
            if (corners.size() % 3 != 0) {
                return malformed("it has " + std::to_string(corners.size())
                                 + " corners, which is not a multiple of three");
            }
            for (size_t k = 0; k < corners.size(); k += 3) add(k, k + 1, k + 2);
        } else {
            for (size_t k = 0; k + 2 < corners.size(); ++k) {
                if (mode == 6)
                    add(0, k + 1, k + 2); // a fan
                else
                    add(k, k + 1 + k % 2, k + 2 - k % 2); // a strip alternates its orientation
            }
        }
        return {};
    }

    // The cofactors: the inverse transpose up to a factor, defined for singular transforms too. A mirrored normal
    // points out of the turned triangle.
    static glm::dmat3 normal_matrix(const glm::dmat4& world) {
        const glm::dmat3 m(world);
        const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
        return glm::determinant(m) < 0.0 ? -cofactors : cofactors;
    }

    static CornerAttributes attributes_of(const Vertices& vertices, uint32_t v, const glm::dmat3& of_normals) {
        CornerAttributes result;
        const auto vector = [v](const Accessor& accessor, int count) {
            glm::dvec4 value(0.0);
            for (int k = 0; k < count; ++k) {
                const double component = accessor.component(v, static_cast<uint64_t>(k));
                value[k] = std::isfinite(component) ? component : 0.0;
            }
            return value;
        };
        for (size_t set = 0; set < 2; ++set)
            if (vertices.uv[set]) result.uv[set] = glm::vec2(vector(*vertices.uv[set], 2));
        if (vertices.normals) {
            const glm::dvec3 normal = of_normals * glm::dvec3(vector(*vertices.normals, 3));
            const double length = glm::length(normal);
            if (length > 0.0 && std::isfinite(length)) result.normal = glm::vec3(normal / length);
        }
        if (vertices.colours) {
            glm::dvec4 colour = vector(*vertices.colours, vertices.has_opacity ? 4 : 3);
            if (!vertices.has_opacity) colour.w = 1.0;
            result.colour = glm::clamp(glm::vec4(colour), 0.0f, 1.0f);
        }
        return result;
    }

    Document& document_;
    bool wants_attributes_;
    Model model_;
    uint64_t vertices_taken_ = 0, triangles_taken_ = 0; // of meshes that take_mesh() moved out of model_
};

} // namespace
} // namespace gltf

Result<Model> read_gltf(std::span<const std::byte> bytes, Companions& companions) {
    Result<gltf::Document> document = gltf::Document::open(bytes, companions);
    if (!document) return document.error();
    return gltf::GltfReader(*document).read();
}

Result<RawScene> read_gltf_scene(std::span<const std::byte> bytes, Companions& companions) {
    Result<gltf::Document> document = gltf::Document::open(bytes, companions);
    if (!document) return document.error();
    return gltf::GltfReader(*document).read_scene();
}

} // namespace brittle::fracture
