#include "fracture/io/export_glb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstring>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "fracture/attributes.h"
#include "fracture/io/atomic_file.h"
#include "fracture/io/certificate_json.h"

namespace brittle::fracture {
namespace {

using Json = nlohmann::ordered_json; // members stay in the order in which a person would read them
using Buffer = std::vector<std::byte>;

constexpr uint64_t size_limit = uint64_t{1} << 32; // sizes in the container are 32-bit
constexpr int deepest_recipe = 64;                 // brackets; writing JSON recurses over them

// Numbers that the glTF 2.0 specification assigns.
constexpr int array_buffer = 34962;
constexpr int element_array_buffer = 34963;
constexpr int unsigned_short = 5123;
constexpr int unsigned_int = 5125;
constexpr int float_32 = 5126;
constexpr uint32_t glb_magic = 0x46546C67;
constexpr uint32_t json_chunk = 0x4E4F534A;
constexpr uint32_t binary_chunk = 0x004E4942;

enum View { positions_view, normals_view, coordinates_view, indices_view };
enum Material { exterior_material, interior_material };

template<class T>
void append(Buffer& buffer, const T& value) {
    const size_t at = buffer.size();
    buffer.resize(at + sizeof(T));
    std::memcpy(buffer.data() + at, &value, sizeof(T));
}

void pad_to_four(Buffer& buffer, std::byte filler) {
    while (buffer.size() % 4 != 0) buffer.push_back(filler);
}

template<class T>
Json array_of(const T& vector) {
    return Json::array({vector.x, vector.y, vector.z});
}

// One primitive before it goes into the buffers.
struct FlatMesh {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<glm::vec2> coordinates; // of textures; or none
    std::vector<uint32_t> indices;
};

// Cosine of the angle between triangles that are in one plane.
constexpr double same_plane = 0.99999;

// Triangles below this share of their longest side in height say nothing about their plane.
constexpr double least_height = 1e-6;

// The triangles begin .. end of a piece, by source and plane: each with the number of its plane. A source has one plane,
// but where pieces have become one, which may have cuts along several bisectors with one neighbour.
std::vector<std::array<uint32_t, 3>> by_plane(const Fragments& fragments, const Piece& piece, uint32_t begin,
                                              uint32_t end) {
    const auto positions = fragments.positions_of(piece);
    const auto triangles = fragments.triangles_of(piece);
    std::vector<std::array<uint32_t, 3>> order; // source, plane, triangle
    for (uint32_t t = begin; t < end; ++t) order.push_back({fragments.triangle_source[piece.triangles.begin + t], 0, t});
    std::sort(order.begin(), order.end());
    std::vector<glm::dvec3> planes; // of the source at hand
    for (size_t k = 0; k < order.size(); ++k) {
        if (k == 0 || order[k][0] != order[k - 1][0]) planes.clear();
        const Triangle& t = triangles[order[k][2]];
        const glm::dvec3 ab = positions[t.y] - positions[t.x], ac = positions[t.z] - positions[t.x];
        const glm::dvec3 normal = glm::cross(ab, ac);
        const double length = glm::length(normal);
        const double longest = std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(ac - ab, ac - ab)});
        if (!(length > least_height * longest)) continue;
        const auto plane = std::find_if(planes.begin(), planes.end(), [&](const glm::dvec3& n) {
            return glm::dot(n, normal) > same_plane * length;
        });
        order[k][1] = static_cast<uint32_t>(plane - planes.begin());
        if (plane == planes.end()) planes.push_back(normal / length);
    }
    std::sort(order.begin(), order.end());
    return order;
}

// The unit normal of triangles in one plane, from the sum of their area vectors: slivers weigh next to
// nothing. +Y for triangles without area, as glTF wants unit length.
glm::vec3 normal_of(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                    std::span<const std::array<uint32_t, 3>> order) {
    glm::dvec3 sum{0.0};
    for (const auto& [source, number, t] : order) {
        const glm::dvec3& a = positions[triangles[t].x];
        sum += glm::cross(positions[triangles[t].y] - a, positions[triangles[t].z] - a);
    }
    // Scaled first, because the squares of tiny areas would vanish.
    const double largest = std::max({std::abs(sum.x), std::abs(sum.y), std::abs(sum.z)});
    if (!(largest > 0.0)) return {0.0f, 1.0f, 0.0f};
    return glm::vec3(glm::normalize(sum / largest));
}

// Makes the split vertices of the triangles begin .. end of a piece; see the header on planes.
FlatMesh flatten(const Fragments& fragments, const Piece& piece, uint32_t begin, uint32_t end,
                 const glm::vec3& translation, std::span<const glm::dvec3> sites) {
    const std::span<const glm::dvec3> positions = fragments.positions_of(piece);
    const std::span<const Triangle> triangles = fragments.triangles_of(piece);
    const bool is_interior = begin >= piece.exterior_triangles;
    const auto order = by_plane(fragments, piece, begin, end);

    FlatMesh flat;
    flat.indices.reserve(order.size() * 3);
    // For each vertex of the piece its copy for the last plane that used it.
    constexpr uint32_t none = ~0u;
    std::vector<uint32_t> copy(positions.size(), none);
    for (size_t first = 0; first < order.size();) {
        size_t last = first;
        while (last < order.size() && order[last][0] == order[first][0] && order[last][1] == order[first][1]) ++last;
        const auto plane = std::span(order).subspan(first, last - first);
        const glm::vec3 normal = normal_of(positions, triangles, plane);
        const size_t first_of_plane = flat.positions.size();
        for (const auto& [source, number, t] : plane) {
            std::array<glm::dvec2, 3> uv{};
            if (is_interior && !sites.empty()) uv = interior_uv(sites, fragments, piece, piece.triangles.begin + t);
            for (int k = 0; k < 3; ++k) {
                const uint32_t vertex = triangles[t][k];
                if (copy[vertex] == none || copy[vertex] < first_of_plane) {
                    copy[vertex] = static_cast<uint32_t>(flat.positions.size());
                    flat.positions.emplace_back(positions[vertex] - glm::dvec3(translation));
                    flat.normals.push_back(normal);
                    // glTF's v points down.
                    const glm::dvec2& at = uv[static_cast<size_t>(k)];
                    if (is_interior && !sites.empty()) flat.coordinates.emplace_back(at.x, -at.y);
                }
                flat.indices.push_back(copy[vertex]);
            }
        }
        first = last;
    }
    return flat;
}

class GlbWriter {
  public:
    GlbWriter(const Fragments& fragments, const Certificate& certificate, const GlbOptions& options)
        : fragments_(fragments), certificate_(certificate), options_(options) {}

    Result<Buffer> write(const Json& recipe) {
        Json root = {{"name", options_.name}};
        Json children = Json::array();
        Json nodes = Json::array({nullptr}); // the root, filled in below
        for (size_t p = 0; p < fragments_.pieces.size(); ++p) {
            Result<Json> node = piece_node(p);
            if (!node) return node.error();
            children.push_back(nodes.size());
            nodes.push_back(std::move(*node));
        }
        if (!children.empty()) root["children"] = std::move(children);
        root["extras"]["brittle"] = {{"certificate", Json::parse(certificate_json(certificate_))}, {"recipe", recipe}};
        nodes[0] = std::move(root);

        Json document;
        document["asset"] = {{"version", "2.0"}, {"generator", "Brittle " BRITTLE_VERSION}};
        document["scene"] = 0;
        document["scenes"] = Json::array({{{"nodes", {0}}}});
        document["nodes"] = std::move(nodes);
        if (!meshes_.empty()) add_buffers(document); // glTF forbids empty lists
        return assemble(document);
    }

  private:
    [[nodiscard]] std::string piece_name(size_t p) const {
        char number[24];
        std::snprintf(number, sizeof(number), "_%03zu", p);
        return options_.name + number;
    }

    Result<Json> piece_node(size_t p) {
        const Piece& piece = fragments_.pieces[p];
        const MassProperties& mass = piece.mass;
        const glm::vec3 translation(mass.centre_of_mass);
        Json primitives = Json::array();
        const uint32_t ends[] = {0, piece.exterior_triangles, piece.triangles.size()};
        for (int part = 0; part < 2; ++part) {
            if (ends[part] == ends[part + 1]) continue;
            const FlatMesh flat = flatten(fragments_, piece, ends[part], ends[part + 1], translation, options_.sites);
            Json primitive = add_primitive(flat);
            primitive["material"] = part == 0 ? exterior_material : interior_material;
            primitives.push_back(std::move(primitive));
            if (Result<void> fits = check(flat, p); !fits) return fits.error();
        }
        Json node = {{"name", piece_name(p)}};
        node["translation"] = array_of(translation);
        if (!primitives.empty()) {
            node["mesh"] = meshes_.size();
            meshes_.push_back({{"name", piece_name(p)}, {"primitives", std::move(primitives)}});
        }
        Json inertia = Json::array();
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) inertia.push_back(mass.inertia[column][row]);
        }
        node["extras"]["brittle"] = {
            {"site", piece.site},
            {"volume", mass.volume},
            {"area", mass.area},
            {"centre_of_mass", array_of(mass.centre_of_mass)},
            {"inertia", std::move(inertia)},
            {"exterior_triangles", piece.exterior_triangles},
            {"interior_triangles", piece.triangles.size() - piece.exterior_triangles}};
        return node;
    }

    // Called after every primitive, so that no more memory is taken than the format could hold.
    Result<void> check(const FlatMesh& flat, size_t p) const {
        if (positions_.size() + normals_.size() + coordinates_.size() + indices_.size() >= size_limit) {
            return Error{Status::write_failed,
                         "the pieces take over 4 GiB, which a GLB file cannot hold; simplify "
                         "the mesh or use fewer sites"};
        }
        for (const glm::vec3& q : flat.positions) {
            if (std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z)) continue;
            return Error{Status::write_failed, piece_name(p)
                                                   + " has a coordinate that does not fit a 32-bit float; "
                                                     "scale the mesh down"};
        }
        return {};
    }

    Json add_primitive(const FlatMesh& flat) {
        glm::vec3 least(flat.positions.front());
        glm::vec3 greatest(least);
        for (const glm::vec3& p : flat.positions) {
            least = glm::min(least, p);
            greatest = glm::max(greatest, p);
        }
        // 65535 restarts a primitive and must not be an index.
        const bool is_short = flat.positions.size() <= 65535;
        const Json position =
            add_accessor(positions_view, positions_.size(), float_32, flat.positions.size(), "VEC3");
        accessors_.back()["min"] = array_of(least);
        accessors_.back()["max"] = array_of(greatest);
        const Json normal =
            add_accessor(normals_view, normals_.size(), float_32, flat.normals.size(), "VEC3");
        const Json indices =
            add_accessor(indices_view, indices_.size(), is_short ? unsigned_short : unsigned_int,
                         flat.indices.size(), "SCALAR");
        Json attributes = {{"POSITION", position}, {"NORMAL", normal}};
        if (!flat.coordinates.empty()) {
            attributes["TEXCOORD_0"] = add_accessor(coordinates_view, coordinates_.size(), float_32,
                                                    flat.coordinates.size(), "VEC2");
            for (const glm::vec2& at : flat.coordinates) append(coordinates_, at);
        }
        for (const glm::vec3& p : flat.positions) append(positions_, p);
        for (const glm::vec3& n : flat.normals) append(normals_, n);
        for (const uint32_t index : flat.indices) {
            if (is_short)
                append(indices_, static_cast<uint16_t>(index));
            else
                append(indices_, index);
        }
        pad_to_four(indices_, std::byte{0});
        return {{"attributes", std::move(attributes)}, {"indices", indices}};
    }

    size_t add_accessor(View view, size_t offset, int component_type, size_t count, const char* type) {
        accessors_.push_back({{"bufferView", static_cast<int>(view)},
                              {"byteOffset", offset},
                              {"componentType", component_type},
                              {"count", count},
                              {"type", type}});
        return accessors_.size() - 1;
    }

    void add_buffers(Json& document) {
        const size_t normals_at = positions_.size();
        const size_t coordinates_at = normals_at + normals_.size();
        const size_t indices_at = coordinates_at + coordinates_.size();
        document["meshes"] = std::move(meshes_);
        // Weathered stone outside; darker and warmer inside, so that a break is seen at once.
        document["materials"] = Json::array({material("exterior", {0.62, 0.60, 0.56, 1.0}, 0.85),
                                             material("interior", {0.36, 0.20, 0.13, 1.0}, 0.95)});
        const auto view = [](size_t offset, size_t length, int target) {
            return Json{{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}, {"target", target}};
        };
        const auto vertices = [&](size_t offset, size_t length, int stride) {
            Json json = view(offset, length, array_buffer);
            json["byteStride"] = stride;
            return json;
        };
        Json views = {vertices(0, positions_.size(), 12), vertices(normals_at, normals_.size(), 12)};
        if (!coordinates_.empty()) views.push_back(vertices(coordinates_at, coordinates_.size(), 8));
        views.push_back(view(indices_at, indices_.size(), element_array_buffer));
        // Views are numbered as if there were coordinates.
        if (coordinates_.empty())
            for (Json& accessor : accessors_)
                if (accessor["bufferView"] == static_cast<int>(indices_view)) accessor["bufferView"] = indices_view - 1;
        document["accessors"] = std::move(accessors_);
        document["bufferViews"] = std::move(views);
        document["buffers"] = Json::array({{{"byteLength", indices_at + indices_.size()}}});
    }

    static Json material(const char* name, const Json& colour, double roughness) {
        return {{"name", name},
                {"pbrMetallicRoughness",
                 {{"baseColorFactor", colour}, {"metallicFactor", 0.0}, {"roughnessFactor", roughness}}},
                {"doubleSided", false}};
    }

    // The container: a head of twelve bytes, the JSON padded with spaces, the buffers padded with zeros.
    Result<Buffer> assemble(const Json& document) const {
        // Names in another encoding than UTF-8 would throw; their damaged letters are replaced.
        std::string json = document.dump(-1, ' ', false, Json::error_handler_t::replace);
        json.resize((json.size() + 3) / 4 * 4, ' ');
        const uint64_t binary = positions_.size() + normals_.size() + coordinates_.size() + indices_.size();
        const uint64_t total = 12 + 8 + json.size() + (binary > 0 ? 8 + binary : 0);
        if (total >= size_limit) {
            return Error{Status::write_failed,
                         "the output takes " + std::to_string(total)
                             + " bytes, and a GLB file must stay below 4 GiB; simplify the mesh "
                               "or use fewer sites"};
        }
        Buffer glb;
        glb.reserve(total);
        for (const uint64_t word :
             {uint64_t{glb_magic}, uint64_t{2}, total, uint64_t{json.size()}, uint64_t{json_chunk}}) {
            append(glb, static_cast<uint32_t>(word));
        }
        const auto* const text = reinterpret_cast<const std::byte*>(json.data());
        glb.insert(glb.end(), text, text + json.size());
        if (binary == 0) return glb;
        append(glb, static_cast<uint32_t>(binary));
        append(glb, binary_chunk);
        for (const Buffer* part : {&positions_, &normals_, &coordinates_, &indices_})
            glb.insert(glb.end(), part->begin(), part->end());
        return glb;
    }

    const Fragments& fragments_;
    const Certificate& certificate_;
    const GlbOptions& options_;
    Json meshes_ = Json::array();
    Json accessors_ = Json::array();
    Buffer positions_;
    Buffer normals_;
    Buffer coordinates_; // may stay empty
    Buffer indices_;
};

Result<Json> parse_recipe(const std::string& text) {
    bool too_deep = false;
    const auto keep = [&](int depth, Json::parse_event_t, Json&) {
        too_deep = too_deep || depth > deepest_recipe;
        return depth <= deepest_recipe;
    };
    Json recipe = Json::parse(text, keep, false);
    if (too_deep) return Error{Status::invalid_setting, "the recipe's JSON is nested over 64 levels deep"};
    if (recipe.is_discarded() || !recipe.is_object()) {
        return Error{Status::invalid_setting,
                     "the recipe is no JSON object, such as {}: " + text.substr(0, 80)};
    }
    return recipe;
}

} // namespace

Result<void> export_glb(const std::filesystem::path& file, const Fragments& fragments,
                        const Certificate& certificate, const GlbOptions& options) {
    const Result<Json> recipe = parse_recipe(options.recipe);
    if (!recipe) return recipe.error();
    const Result<Buffer> glb = GlbWriter(fragments, certificate, options).write(*recipe);
    if (!glb) return Error{glb.error().status, file.string() + ": " + glb.error().message};
    return write_file_atomically(file, *glb);
}

} // namespace brittle::fracture
