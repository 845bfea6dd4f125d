// The looks of a mesh on the stage: the materials, textures and colours that its file has, and where they lie on its
// triangles. Pieces take them from here, however often they are cut.
//
//     std::shared_ptr<const MeshLooks> looks = looks_of(model, stage_mesh, notes); // on any thread; null without any
//     PieceMesh piece{..., .corners = corners};                                    // of looks->corners(source, points)
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/render/material_set.h"
#include "engine/render/scene.h"
#include "fracture/io/model.h"
#include "fracture/mesh/mesh.h"
#include "tools/scenario/recipe/picture_options.h"

namespace brittle::tools {

// Decodes the textures of a model. Null where the file has neither materials nor colours, and no image for cuts is
// given. An image that cannot be shown gives a note for people, and the material its plain colour. `cuts`: null or an
// image for fracture surfaces. On any thread.
[[nodiscard]] std::shared_ptr<const engine::MaterialSet>
materials_of(const fracture::Model& model, std::vector<std::string>& notes, const fracture::Image* cuts = nullptr);

struct MeshLooks {
    std::shared_ptr<const engine::MaterialSet> materials; // never null
    bool of_mesh = false;                                 // false: only the cuts have an image
    fracture::TriangleMesh mesh;                          // as on the stage; without triangles unless of_mesh
    // As in fracture::Model.
    std::array<std::vector<glm::vec2>, 2> uv;
    std::vector<glm::vec4> colours;
    std::vector<uint32_t> material_of;
    std::vector<uint8_t> uv_set; // by material

    // Returns the attributes of three points on a triangle of the mesh.
    [[nodiscard]] std::array<engine::CornerLook, 3> corners(uint32_t triangle,
                                                            const std::array<glm::dvec3, 3>& points) const;
};

// `mesh` has the triangles of the model's mesh, moved and scaled; `turned`: mirrored, with the last two corners of each
// triangle exchanged. Null without materials.
[[nodiscard]] std::shared_ptr<const MeshLooks> looks_of(const fracture::Model& model,
                                                        const fracture::TriangleMesh& mesh,
                                                        std::shared_ptr<const engine::MaterialSet> materials,
                                                        bool turned = false);

// Whether the looks of an input are wanted: a picture shows them, or may.
[[nodiscard]] bool wants_looks(const PictureOptions& picture);

// The looks of a mesh that was loaded with them, on the stage. Null without any, and where the picture wants none.
// Throws a Failure if the picture's image for fracture surfaces cannot be read.
[[nodiscard]] std::shared_ptr<const MeshLooks> looks_for(const fracture::Model& model,
                                                         const fracture::TriangleMesh& on_stage,
                                                         const PictureOptions& picture,
                                                         std::vector<std::string>& notes);

// The image for fracture surfaces; nothing without one. Throws a Failure.
[[nodiscard]] std::optional<fracture::Image> interior_image(const PictureOptions& picture);

// Whether pieces are drawn with materials: as the options say, or else where a mesh has some.
[[nodiscard]] bool shows_materials(PieceColours colours, bool has_materials);

} // namespace brittle::tools
