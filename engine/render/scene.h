// The content of a frame: plain data that the caller fills each frame. The geometry of pieces is uploaded separately,
// by Renderer::add_pieces().
//
// Right-handed, Y up, metres. Colours are linear light in [0, 1] unless marked as sRGB.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <span>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "engine/camera/camera.h"
#include "engine/camera/sun.h"

namespace brittle::engine {

// The attributes of a corner of a triangle, in the layout that the GPU reads.
struct CornerLook {
    glm::vec2 uv{0.0f};            // of the textures; (0, 0) is the upper left corner of the image
    uint32_t colour = 0xffffffffu; // srgb8(), with opacity in the highest byte
    uint32_t material = 0;         // 1 + index into MaterialSet::materials, or 0 for the look of the scene

    friend bool operator==(const CornerLook&, const CornerLook&) = default;
};
static_assert(sizeof(CornerLook) == 16, "the layout of the vertex attributes");

// One piece to upload: a triangle list, counter-clockwise seen from outside, exterior triangles first.
struct PieceMesh {
    std::span<const glm::vec3> positions{};  // the origin is the body's centre of mass, unless attached with an offset
    std::span<const glm::uvec3> triangles{}; // indices into positions
    uint32_t exterior_triangles = 0;         // number of exterior triangles, the first of `triangles`
    uint32_t body = 0;                       // index of the pose that moves the piece; several pieces may share a body
    glm::vec3 tint{1.0f};                    // multiplies both materials; piece_tint()
    // Exterior triangles of other pieces around this one. They are not drawn, but count for the normals of vertices on
    // the border. The vertices that only these triangles use are the last ones.
    std::span<const glm::uvec3> neighbours{};
    // Of the corners of the exterior triangles, for Scene::materials; or none.
    std::span<const CornerLook> corners{};
    glm::vec3 centre{0.0f}; // as PieceAttachment::centre
};

// What moves a piece, and how it is shown.
struct PieceAttachment {
    uint32_t body = 0;      // as PieceMesh::body
    glm::vec3 tint{1.0f};   // as PieceMesh::tint
    glm::vec3 offset{0.0f}; // m, from the body's centre of mass to the origin of the positions, in the body's frame
    uint32_t id = 0;        // what Renderer::render_ids() shows; 0: the number of the handle
    uint32_t surface = 0;   // 0: the look of the scene; k: Scene::surfaces[k - 1], as far as there are so many
    glm::vec3 centre{0.0f}; // m, the body's centre of mass in the object; places the grain of its fracture surfaces
    // The materials of the sets before that of the piece's mesh (Renderer::set_materials()).
    uint32_t first_material = 0;
};

// The handle of an uploaded piece, unique in a renderer's life. Handles are ordered by the time of adding. 0 is no
// piece.
struct PieceHandle {
    uint32_t number = 0;

    friend constexpr auto operator<=>(PieceHandle, PieceHandle) = default;
};

// The pose of a body, in the layout that the GPU reads. Scene::write_poses writes poses directly into mapped memory,
// which may be slow to read: write each pose once, and read none.
struct BodyPose {
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f}; // unit length
    glm::vec3 position{0.0f};                   // of the body's centre of mass
    float scale = 1.0f;                         // about the centre of mass; 0 hides the body
};
static_assert(sizeof(BodyPose) == 32, "the layout that shaders/shared.h declares");

// Returns the tint of piece `index`, from a fixed infinite sequence of soft colours with distant hues for consecutive
// indices.
[[nodiscard]] glm::vec3 piece_tint(uint32_t index);

// Packs a LineVertex::colour from sRGB components in [0, 255].
[[nodiscard]] constexpr uint32_t srgb8(uint32_t red, uint32_t green, uint32_t blue) {
    return red | green << 8 | blue << 16 | 0xff000000u;
}

struct LineVertex {
    glm::vec3 position{0.0f};
    uint32_t colour = srgb8(215, 38, 30);
};
static_assert(sizeof(LineVertex) == 16, "the layout of the vertex attributes");

struct Sphere {
    glm::vec3 centre{0.0f};
    float radius = 0.01f;
};
static_assert(sizeof(Sphere) == 16, "the layout of the instance attributes");

// A splinter that a break threw off: a small opaque shard.
struct Splinter {
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f}; // unit length
    glm::vec3 centre{0.0f};
    float length = 0.01f; // m, half of its longest side
    glm::vec3 colour{0.5f};
    float width = 0.4f; // its shorter sides, as a share of the longest
};
static_assert(sizeof(Splinter) == 48, "the layout of the instance attributes");

// A puff of dust: a ball of haze, densest in its middle.
struct DustPuff {
    glm::vec3 centre{0.0f};
    float radius = 0.1f; // m
    glm::vec3 colour{0.5f};
    float opacity = 0.2f; // share of the light from behind that the middle takes
    uint32_t pattern = 0; // puffs of different numbers look different
};
static_assert(sizeof(DustPuff) == 36, "the layout of the instance attributes");

// The pattern of fracture surfaces in the view of materials (shaders/grain.glsl).
enum class Grain { plain, glass, stone, concrete, wood, ceramic, brick };

// The materials of some pieces, in place of those of the look.
struct SurfaceLook {
    glm::vec3 exterior{0.66f, 0.615f, 0.54f};
    glm::vec3 interior{0.40f, 0.125f, 0.06f};
    float tint = 0.5f; // as Look::tint
    Grain grain = Grain::plain;
};

// Materials and light. The defaults are off-white stone with a terracotta interior.
struct Look {
    glm::vec3 exterior{0.66f, 0.615f, 0.54f};
    glm::vec3 interior{0.40f, 0.125f, 0.06f};
    float tint = 0.5f; // weight of the pieces' tints, 0 to 1
    Grain grain = Grain::plain;
    glm::vec3 sphere{0.72f, 0.03f, 0.02f};
    glm::vec3 ground{0.50f, 0.495f, 0.49f};
    glm::vec3 background_top{0.40f, 0.43f, 0.47f};
    glm::vec3 background_bottom{0.62f, 0.61f, 0.60f};
    glm::vec3 to_light = default_to_light;   // direction to the sun, of any length but zero
    glm::vec3 sun{1.00f, 0.93f, 0.83f};      // light of the sun
    glm::vec3 sky{0.36f, 0.40f, 0.47f};      // ambient light from above
    glm::vec3 bounce{0.17f, 0.145f, 0.125f}; // ambient light from below
    float exposure = 1.0f;                   // factor of all light before the filmic curve
};

// A rectangle of the picture, as shares of its width and height from the top left corner.
struct Region {
    glm::vec2 min{0.0f}, max{1.0f};
};

struct Scene {
    Camera camera{};
    // The part of the picture to draw; pixels outside, which panels cover, are undefined. Pixels inside equal those of
    // the whole picture.
    Region region{};
    // A box around everything that casts a shadow in this frame. The shadow map and the depth range are fitted to it.
    // Geometry outside is drawn without a shadow. Large bounds make coarse shadows.
    Bounds bounds{};
    // Writes the poses of the bodies; called once in each draw. The span has Renderer::body_count() poses, in the
    // mapped memory of a frame in flight, and holds the poses that were written there at the moment `since`. Bodies
    // that have not moved after `since` need no write. At `since` 0, every pose is BodyPose{} and must be written.
    // Unset: every body is at the origin.
    std::function<void(std::span<BodyPose>, uint64_t since)> write_poses{};
    // The caller's counter of pose changes, as of this frame. 0: no counter, and `since` is always 0. `since` is also 0
    // after the number of bodies has grown, and when the moment is less than that of an earlier frame.
    uint64_t moment = 0;
    // False: no pose differs from the previous draw's, so the shadow map is reused.
    bool moved = true;

    std::span<const LineVertex> lines{}; // two vertices for each line: debug lines, cell edges
    bool lines_on_top = false;           // true: visible through pieces; false: hidden behind them
    std::span<const Sphere> spheres{};   // Voronoi sites, or balls
    bool spheres_on_top = false;
    bool spheres_cast_shadows = false; // true for balls, false for marks; within the bounds
    std::span<const Splinter> splinters{};
    std::span<const DustPuff> dust{}; // in any order; it casts no shadows
    bool pieces_visible = true;       // false: only lines, spheres and the ground are drawn
    bool smooth = false; // true: exterior normals are interpolated except across creases; false: flat shading
    // True: pieces have the materials of their meshes (Renderer::set_materials()), without tints, and their fracture
    // surfaces have a grain. False: they have the colours of the look, and their tints.
    bool materials = false;
    bool wireframe = false; // triangle edges over the pieces; needs Device::has_line_mode()
    bool ground = true;
    float ground_height = 0.0f; // y of the ground plane

    Look look{};
    std::span<const SurfaceLook> surfaces{}; // of PieceAttachment::surface; at most max_surfaces - 1 (shaders/shared.h)
};

} // namespace brittle::engine
