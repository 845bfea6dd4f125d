#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include <glm/ext/vector_uint2_sized.hpp>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "fracture/io/bytes.h"
#include "fracture/io/certificate_json.h"
#include "fracture/io/glb_materials.h"
#include "fracture/io/piece_surface.h"
#include "fracture/io/rigid_body_json.h"
#include "fracture/io/tangents.h"
#include "fracture/io/writers.h"

namespace brittle::fracture {
namespace {

using Json = nlohmann::ordered_json; // keeps members in the order of a reader
using Buffer = std::vector<std::byte>;

constexpr uint64_t size_limit = uint64_t{1} << 32; // sizes in the container are 32-bit
constexpr int max_recipe_depth = 64;               // brackets; the JSON writer recurses over them

// Numbers that the glTF 2.0 specification assigns.
constexpr int array_buffer = 34962;
constexpr int element_array_buffer = 34963;
constexpr int unsigned_short = 5123;
constexpr int unsigned_int = 5125;
constexpr int float_32 = 5126;
constexpr uint32_t glb_magic = 0x46546C67;
constexpr uint32_t json_chunk = 0x4E4F534A;
constexpr uint32_t binary_chunk = 0x004E4942;

template<class T>
Json array_of(const T& vector) {
    return Json::array({vector.x, vector.y, vector.z});
}

// The single buffer, in views: one for each kind of attribute, one for each image. A view gets its index at the first
// write to it, and its offset when all views are complete.
class Views {
  public:
    struct View {
        Buffer bytes{};
        int stride = 0; // 0: unspecified
        int target = 0; // 0: unspecified
    };

    size_t number(const std::string& kind, int stride, int target) {
        const auto [known, is_new] = numbers_.emplace(kind, views_.size());
        if (is_new) views_.push_back({{}, stride, target});
        return known->second;
    }
    size_t add(Buffer bytes) {
        views_.push_back({std::move(bytes)});
        return views_.size() - 1;
    }
    Buffer& bytes(size_t view) { return views_[view].bytes; }

    [[nodiscard]] uint64_t size() const {
        uint64_t sum = 0;
        for (const View& view : views_) sum += (view.bytes.size() + 3) / 4 * 4;
        return sum;
    }
    [[nodiscard]] bool empty() const { return views_.empty(); }

    [[nodiscard]] Json json() const {
        Json result = Json::array();
        uint64_t offset = 0;
        for (const View& view : views_) {
            Json json = {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", view.bytes.size()}};
            if (view.stride > 0) json["byteStride"] = view.stride;
            if (view.target > 0) json["target"] = view.target;
            result.push_back(std::move(json));
            offset += (view.bytes.size() + 3) / 4 * 4;
        }
        return result;
    }
    // Moves the content to the end of the file: each view is freed when it is there.
    void move_to(Buffer& glb) {
        for (View& view : views_) {
            glb.insert(glb.end(), view.bytes.begin(), view.bytes.end());
            view.bytes = {};
            while (glb.size() % 4 != 0) glb.push_back(std::byte{0});
        }
    }

  private:
    std::map<std::string, size_t> numbers_;
    std::vector<View> views_;
};

// Names that are not UTF-8 would throw; the replacement character takes the place of invalid bytes.
std::string text_of(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// A JSON array, kept as text: the objects of a large file would take many times the memory of their text.
class JsonList {
  public:
    [[nodiscard]] size_t size() const { return entries_.size(); }
    [[nodiscard]] bool empty() const { return entries_.empty(); }
    // Returns the place of the entry.
    size_t add(const Json& entry) {
        entries_.push_back(text_of(entry));
        return entries_.size() - 1;
    }
    void set(size_t place, const Json& entry) { entries_[place] = text_of(entry); }
    // Moves the array to the end of the text.
    void move_to(std::string& text) {
        text += '[';
        for (size_t k = 0; k < entries_.size(); ++k) {
            if (k > 0) text += ',';
            text += entries_[k];
            entries_[k] = {};
        }
        text += ']';
        entries_.clear();
    }

  private:
    std::vector<std::string> entries_;
};

class GlbWriter {
  public:
    // Adds an object: a root node with its pieces as children. `extras` are the root's.
    Result<void> add(const ExportJob& job, Json extras) {
        job_ = &job;
        materials_.use(job.options);
        bonds_.clear();
        for (const Bond& bond : job.fragments.bonds) bonds_[bond.a].push_back(&bond);
        Json root = {{"name", job.options.name}};
        Json children = Json::array();
        const size_t at = nodes_.add(nullptr);
        for (const uint32_t p : job.pieces) {
            children.push_back(nodes_.size());
            if (Result<void> done = add_piece(p); !done) return done;
        }
        if (!children.empty()) root["children"] = std::move(children);
        root["extras"]["brittle"] = std::move(extras);
        nodes_.set(at, root);
        roots_.push_back(at);
        if (job.options.rigid_bodies) extensions_.insert(rigid_body_extension);
        return {};
    }

    // Once. There are objects.
    Result<Buffer> write() {
        Json document;
        document["asset"] = {{"version", "2.0"}, {"generator", "Brittle " BRITTLE_VERSION}};
        document["scene"] = 0;
        document["scenes"] = Json::array({{{"nodes", roots_}}});
        document["nodes"] = nullptr; // assemble() puts the lists in the places of these
        if (!meshes_.empty()) {      // glTF forbids empty lists
            document["meshes"] = nullptr;
            materials_.add_to(document, extensions_, [this](Buffer bytes) { return views_.add(std::move(bytes)); });
            document["accessors"] = nullptr;
            document["bufferViews"] = views_.json();
            document["buffers"] = Json::array({{{"byteLength", views_.size()}}});
        }
        if (!extensions_.empty()) document["extensionsUsed"] = extensions_;
        return assemble(document);
    }

  private:
    [[nodiscard]] static Json json_of(std::span<const Bond* const> bonds) {
        Json list = Json::array();
        for (const Bond* bond : bonds)
            list.push_back({{"piece", bond->b},
                            {"area", bond->area},
                            {"centroid", array_of(bond->centroid)},
                            {"normal", array_of(bond->normal)}});
        return list;
    }

    Result<void> add_piece(uint32_t p) {
        const Piece& piece = job_->fragments.pieces[p];
        const MassProperties& mass = piece.mass;
        const glm::dvec3 origin = origin_of(mass);
        const std::string name = piece_name(job_->options, p);
        Json primitives = Json::array();
        const bool touches = has_touching_points(piece, origin);
        for (const DrawnPart& part : drawn_parts(job_->fragments, piece, surface_settings(*job_))) {
            Result<Json> primitive = add_part(part, piece, origin, name, touches);
            if (!primitive) return primitive.error();
            primitives.push_back(std::move(*primitive));
        }
        Json node = {{"name", name + body_suffix()}};
        place(node, p, origin);
        if (!primitives.empty()) {
            node["mesh"] = meshes_.size();
            meshes_.add({{"name", name}, {"primitives", std::move(primitives)}});
        }
        Json inertia = Json::array();
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) inertia.push_back(mass.inertia[column][row]);
        }
        Json& extras = node["extras"]["brittle"];
        extras = {{"site", piece.site},
                  {"volume", mass.volume},
                  {"area", mass.area},
                  {"centre_of_mass", array_of(mass.centre_of_mass)},
                  {"inertia", std::move(inertia)},
                  {"exterior_triangles", piece.exterior_triangles},
                  {"interior_triangles", piece.triangles.size() - piece.exterior_triangles}};
        if (const auto bonds = bonds_.find(p); bonds != bonds_.end()) extras["bonds"] = json_of(bonds->second);

        const size_t at = nodes_.add(nullptr);
        if (Result<void> done = add_hulls(node, p, origin, name); !done) return done.error();
        nodes_.set(at, node);
        return {};
    }

    // The mass properties in the axes of the node; the centre of mass is rounded where it is also the translation.
    [[nodiscard]] glm::dvec3 origin_of(const MassProperties& mass) const {
        return job_->options.poses.empty() ? glm::dvec3(glm::vec3(mass.centre_of_mass)) : mass.centre_of_mass;
    }

    void place(Json& node, uint32_t p, const glm::dvec3& origin) const {
        if (job_->options.poses.empty()) {
            node["translation"] = array_of(glm::vec3(origin));
            return;
        }
        const PiecePose& pose = job_->options.poses[p];
        const glm::quat turn(glm::normalize(pose.orientation));
        node["translation"] = array_of(glm::vec3(pose.position));
        node["rotation"] = {turn.x, turn.y, turn.z, turn.w};
    }

    [[nodiscard]] const char* body_suffix() const {
        if (job_->options.body_names != BodyNames::godot) return "";
        return job_->options.fixed ? "-col" : "-rigid";
    }

    // A single hull is the collider of its piece; several hulls are colliders of their own nodes.
    Result<void> add_hulls(Json& node, uint32_t p, const glm::dvec3& origin, const std::string& name) {
        const ExportOptions& options = job_->options;
        if (options.fixed) {
            if (options.rigid_bodies && node.contains("mesh"))
                node["extensions"][rigid_body_extension] = surface_collider_json(node["mesh"]);
            return {};
        }
        const bool drawn = options.body_names == BodyNames::unreal; // as the mesh of a node
        std::vector<size_t> meshes;
        if (!options.hulls.empty() && (drawn || options.rigid_bodies)) {
            for (const TriangleMesh& hull : options.hulls[p]) {
                if (hull.triangles.empty()) continue;
                const Result<size_t> mesh = add_hull_mesh(hull, origin, hull_name(name, meshes.size()));
                if (!mesh) return mesh.error();
                meshes.push_back(*mesh);
            }
        }
        const bool alone = meshes.size() == 1;
        if (options.rigid_bodies)
            node["extensions"][rigid_body_extension] = rigid_body_json(
                job_->fragments.pieces[p].mass, options.density, alone ? std::optional(meshes.front()) : std::nullopt);
        const bool collides = options.rigid_bodies && !alone; // as a node
        if (!drawn && !collides) return {};
        for (size_t k = 0; k < meshes.size(); ++k) {
            Json hull = {{"name", hull_name(name, k)}};
            if (drawn) hull["mesh"] = meshes[k];
            if (collides) hull["extensions"][rigid_body_extension] = collider_json(meshes[k]);
            node["children"].push_back(nodes_.add(hull));
        }
        return {};
    }

    [[nodiscard]] std::string hull_name(const std::string& piece, size_t hull) const {
        char number[24];
        std::snprintf(number, sizeof number, "_%02zu", hull);
        return job_->options.body_names == BodyNames::unreal ? "UCX_" + piece + number : piece + "_hull" + number;
    }

    // Returns the number of the mesh.
    Result<size_t> add_hull_mesh(const TriangleMesh& hull, const glm::dvec3& origin, const std::string& name) {
        std::vector<glm::vec3> positions;
        for (const glm::dvec3& p : hull.positions) positions.emplace_back(p - origin);
        std::vector<uint32_t> indices;
        for (const Triangle& t : hull.triangles)
            for (int k = 0; k < 3; ++k) indices.push_back(t[k]);
        Result<Json> attributes = add_positions(positions, name);
        if (!attributes) return attributes.error();
        Json primitive = {{"attributes", std::move(*attributes)}, {"indices", add_indices(indices, positions.size())}};
        return meshes_.add({{"name", name}, {"primitives", Json::array({std::move(primitive)})}});
    }

    // Checked for every primitive, so that no more memory is allocated than the format can hold.
    Result<Json> add_positions(std::span<const glm::vec3> positions, const std::string& name) {
        if (views_.size() >= size_limit) {
            return Error{Status::write_failed, "the pieces take over 4 GiB, which a GLB file cannot hold; simplify "
                                               "the mesh or use fewer sites"};
        }
        glm::vec3 least(positions.front());
        glm::vec3 greatest(least);
        for (const glm::vec3& p : positions) {
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
                return Error{Status::write_failed,
                             name + " has a coordinate that does not fit a 32-bit float; scale the mesh down"};
            }
            least = glm::min(least, p);
            greatest = glm::max(greatest, p);
        }
        const Json range{{"min", array_of(least)}, {"max", array_of(greatest)}};
        return Json{{"POSITION", add_accessor("positions", positions, "VEC3", float_32, range)}};
    }

    // Returns whether several vertices of the piece have one position in single precision.
    [[nodiscard]] bool has_touching_points(const Piece& piece, const glm::dvec3& origin) const {
        std::vector<glm::vec3> positions;
        for (const glm::dvec3& p : job_->fragments.positions_of(piece)) positions.emplace_back(p - origin);
        const auto before = [](const glm::vec3& a, const glm::vec3& b) {
            return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
        };
        std::sort(positions.begin(), positions.end(), before);
        return std::adjacent_find(positions.begin(), positions.end()) != positions.end();
    }

    // `touches`: with _POINT, so that a reader does not weld vertices of parts that touch.
    Result<Json> add_part(const DrawnPart& part, const Piece& piece, const glm::dvec3& origin, const std::string& name,
                          bool touches) {
        const auto of_piece = job_->fragments.positions_of(piece);
        std::vector<glm::vec3> positions;
        positions.reserve(part.vertices.size());
        for (const uint32_t v : part.vertices) positions.emplace_back(of_piece[v] - origin);
        Result<Json> attributes = add_positions(positions, name);
        if (!attributes) return attributes.error();
        (*attributes)["NORMAL"] = add_accessor("normals", std::span<const glm::vec3>(part.normals), "VEC3");
        if (!part.tangents.empty())
            (*attributes)["TANGENT"] = add_accessor("tangents", std::span<const glm::vec4>(part.tangents), "VEC4");
        if (!part.uv[0].empty()) {
            (*attributes)["TEXCOORD_0"] = add_accessor("uv", std::span<const glm::vec2>(part.uv[0]), "VEC2");
            if (!part.uv[1].empty())
                (*attributes)["TEXCOORD_1"] = add_accessor("uv", std::span<const glm::vec2>(part.uv[1]), "VEC2");
        }
        if (!part.colours.empty())
            (*attributes)["COLOR_0"] = add_accessor("colours", std::span<const glm::vec4>(part.colours), "VEC4");
        if (touches) (*attributes)["_POINT"] = add_points(part, piece);
        return Json{{"attributes", std::move(*attributes)},
                    {"indices", add_indices(part.indices, positions.size())},
                    {"material", materials_.material_of(part)}};
    }

    // `more`: further members of the accessor.
    template<class T>
    size_t add_accessor(const char* kind, std::span<const T> values, const char* type, int component_type = float_32,
                        const Json& more = {}) {
        const size_t view = views_.number(kind, sizeof(T), array_buffer);
        Buffer& bytes = views_.bytes(view);
        Json accessor{{"bufferView", view},
                      {"byteOffset", bytes.size()},
                      {"componentType", component_type},
                      {"count", values.size()},
                      {"type", type}};
        if (!more.is_null()) accessor.update(more);
        const auto raw = std::as_bytes(values);
        bytes.insert(bytes.end(), raw.begin(), raw.end());
        return accessors_.add(accessor);
    }

    // Attributes may not have 32-bit integers, so the number of a vertex is two halves, the low one first.
    size_t add_points(const DrawnPart& part, const Piece& piece) {
        std::vector<glm::u16vec2> halves;
        for (const uint32_t v : part.vertices) {
            const uint32_t number = piece.vertices.begin + v;
            halves.emplace_back(number & 0xffffu, number >> 16);
        }
        return add_accessor("points", std::span<const glm::u16vec2>(halves), "VEC2", unsigned_short);
    }

    size_t add_indices(std::span<const uint32_t> indices, size_t vertices) {
        const bool is_short = vertices <= 65535; // 65535 is the restart value and no valid index
        const size_t view = views_.number("indices", 0, element_array_buffer);
        Buffer& bytes = views_.bytes(view);
        const size_t accessor = accessors_.add({{"bufferView", view},
                                                {"byteOffset", bytes.size()},
                                                {"componentType", is_short ? unsigned_short : unsigned_int},
                                                {"count", indices.size()},
                                                {"type", "SCALAR"}});
        for (const uint32_t index : indices) {
            if (is_short)
                append(bytes, static_cast<uint16_t>(index));
            else
                append(bytes, index);
        }
        while (bytes.size() % 4 != 0) bytes.push_back(std::byte{0});
        return accessor;
    }

    // The container: a header of twelve bytes, the JSON padded with spaces, the buffer padded with zeros.
    Result<Buffer> assemble(const Json& document) {
        const std::map<std::string, JsonList*> lists{
            {"nodes", &nodes_}, {"meshes", &meshes_}, {"accessors", &accessors_}};
        std::string json;
        for (const auto& [key, value] : document.items()) {
            json += (json.empty() ? "{\"" : ",\"") + key + "\":";
            if (const auto list = lists.find(key); list != lists.end())
                list->second->move_to(json);
            else
                json += text_of(value);
        }
        json += '}';
        json.resize((json.size() + 3) / 4 * 4, ' ');
        const uint64_t binary = views_.size();
        const uint64_t total = 12 + 8 + json.size() + (binary > 0 ? 8 + binary : 0);
        if (total >= size_limit) {
            return Error{Status::write_failed, "the output takes " + std::to_string(total)
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
        views_.move_to(glb);
        return glb;
    }

    const ExportJob* job_ = nullptr; // the one that add() adds
    GlbMaterials materials_;
    std::vector<size_t> roots_;
    std::map<uint32_t, std::vector<const Bond*>> bonds_; // of each piece to those with a higher number, in any file
    JsonList nodes_, meshes_, accessors_;
    Views views_;
    std::set<std::string> extensions_;
};

Result<Json> parse_recipe(const std::string& text) {
    bool too_deep = false;
    const auto keep = [&](int depth, Json::parse_event_t, Json&) {
        too_deep = too_deep || depth > max_recipe_depth;
        return depth <= max_recipe_depth;
    };
    Json recipe = Json::parse(text, keep, false);
    if (too_deep) return Error{Status::invalid_setting, "the recipe's JSON is nested over 64 levels deep"};
    if (recipe.is_discarded() || !recipe.is_object()) {
        return Error{Status::invalid_setting, "the recipe is not a JSON object, for example {}: " + text.substr(0, 80)};
    }
    return recipe;
}

} // namespace

Result<std::vector<OutputFile>> write_glb(const ExportJob& job) {
    const Result<Json> recipe = parse_recipe(job.options.recipe);
    if (!recipe) return recipe.error();
    GlbWriter writer;
    const Json extras{{"certificate", Json::parse(certificate_json(job.certificate))}, {"recipe", *recipe}};
    if (Result<void> done = writer.add(job, extras); !done) return done.error();
    Result<Buffer> glb = writer.write();
    if (!glb) return glb.error();
    return std::vector<OutputFile>{{"", std::move(*glb)}};
}

struct ObjectExport::Writer : GlbWriter {};

ObjectExport::ObjectExport() : writer_(std::make_unique<Writer>()) {}
ObjectExport::~ObjectExport() = default;

Result<void> ObjectExport::add(const Fragments& fragments, const ExportOptions& options) {
    if (Result<void> valid = check_export(fragments, options); !valid) return valid;
    const Result<Json> recipe = parse_recipe(options.recipe);
    if (!recipe) return recipe.error();
    std::vector<uint32_t> pieces(fragments.pieces.size());
    std::iota(pieces.begin(), pieces.end(), 0u);
    const std::optional<TriangleTree> outside = outside_of(options);
    const std::vector<glm::vec4> tangents =
        options.source ? corner_tangents(*options.source) : std::vector<glm::vec4>();
    const Certificate none;
    const ExportJob job{fragments, none, options, pieces, "", outside ? &*outside : nullptr, tangents};
    has_objects_ = true;
    return writer_->add(job, {{"object", options.name}, {"recipe", *recipe}});
}

Result<std::vector<std::byte>> ObjectExport::bytes() {
    if (!has_objects_) return Error{Status::invalid_setting, "there are no objects to export"};
    return writer_->write();
}

} // namespace brittle::fracture
