// Builds GLB files by hand, for tests of readers: meshes as triangles, and all other JSON as text.
//
//     GlbFile glb;
//     glb.add_mesh(cube, R"("name": "Crate")", 0);
//     folder.write("a.glb", glb.bytes(R"("nodes": [{"mesh": 0}], "materials": [{"name": "Wood"}])"));
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "fracture/mesh/mesh.h"

namespace brittle::test_files {

class GlbFile {
  public:
    // A mesh of one primitive; positions in single precision. `members`: further JSON members of the mesh. A negative
    // material is none.
    void add_mesh(const fracture::TriangleMesh& mesh, const std::string& members = "", int material = -1) {
        const std::string vertices = std::to_string(views_++), corners = std::to_string(views_++);
        view(mesh.positions.size() * 12);
        for (const glm::dvec3& p : mesh.positions)
            for (int axis = 0; axis < 3; ++axis) put(static_cast<float>(p[axis]));
        view(mesh.triangles.size() * 12);
        for (const fracture::Triangle& t : mesh.triangles)
            for (int k = 0; k < 3; ++k) put(t[k]);
        list(accessors_) += R"({"bufferView": )" + vertices + R"(, "componentType": 5126, "type": "VEC3", "count": )"
                            + std::to_string(mesh.positions.size()) + R"(}, {"bufferView": )" + corners
                            + R"(, "componentType": 5125, "type": "SCALAR", "count": )"
                            + std::to_string(3 * mesh.triangles.size()) + "}";
        list(meshes_) += R"({"primitives": [{"attributes": {"POSITION": )" + vertices + R"(}, "indices": )" + corners
                         + (material < 0 ? "" : R"(, "material": )" + std::to_string(material)) + "}]"
                         + (members.empty() ? "" : ", " + members) + "}";
    }

    // The file; `members`: the nodes, and all else at the top of its JSON.
    [[nodiscard]] std::string bytes(const std::string& members) const {
        std::string json = R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": )"
                           + std::to_string(binary_.size()) + R"(}], "bufferViews": [)" + buffer_views_
                           + R"(], "accessors": [)" + accessors_ + R"(], "meshes": [)" + meshes_ + "], " + members
                           + "}";
        json.resize((json.size() + 3) / 4 * 4, ' ');
        const auto size = static_cast<uint32_t>(12 + 8 + json.size() + 8 + binary_.size());
        return word(0x46546C67) + word(2) + word(size) + word(static_cast<uint32_t>(json.size())) + word(0x4E4F534A)
               + json + word(static_cast<uint32_t>(binary_.size())) + word(0x004E4942) + binary_;
    }

  private:
    static std::string& list(std::string& values) { return values += values.empty() ? "" : ", "; }

    static std::string word(uint32_t value) {
        char bytes[4];
        std::memcpy(bytes, &value, 4);
        return {bytes, 4};
    }

    template<class T>
    void put(T value) {
        char bytes[4];
        static_assert(sizeof value == 4);
        std::memcpy(bytes, &value, 4);
        binary_.append(bytes, 4);
    }

    void view(size_t size) {
        list(buffer_views_) += R"({"buffer": 0, "byteOffset": )" + std::to_string(binary_.size())
                               + R"(, "byteLength": )" + std::to_string(size) + "}";
    }

    int views_ = 0;
    std::string buffer_views_, accessors_, meshes_, binary_;
};

} // namespace brittle::test_files
