// The materials of a mesh and their textures, ready for the device. Made on any thread, immutable, and shared by all
// pieces of the mesh.
//
//     auto set = std::make_shared<MaterialSet>(MaterialSet{.materials = ..., .base_colours = TextureStack::of(images)});
//     renderer.set_materials({set});
//     PieceMesh piece{..., .corners = corners};        // each names a material of the set
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "engine/render/texture_stack.h"

namespace brittle::engine {

enum class Wrap { repeat, clamp, mirror };
enum class Opacity {
    opaque,
    mask, // pixels below the cutoff are cut out
    blend // drawn as a share of the pixels (shaders/fade.glsl)
};

// A texture of a material, with a transform of its coordinates: u' = turn * u + offset.
struct MaterialTexture {
    uint32_t layer = 0; // of the set's stack
    Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
    glm::mat2 turn{1.0f};
    glm::vec2 offset{0.0f};
};

struct MeshMaterial {
    glm::vec4 colour{1.0f}; // linear, with opacity; factor of texture and vertex colours
    Opacity opacity = Opacity::opaque;
    float cutoff = 0.5f; // of Opacity::mask
    std::optional<MaterialTexture> base_colour{};
    std::optional<MaterialTexture> normal_map{};
    float normal_scale = 1.0f;
};

struct MaterialSet {
    std::vector<MeshMaterial> materials{};
    TextureStack base_colours{};
    TextureStack normal_maps{};     // made with StackSettings::srgb false
    std::optional<uint32_t> cuts{}; // layer of base_colours for fracture surfaces, repeated every metre
};

} // namespace brittle::engine
