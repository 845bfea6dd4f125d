// The vertex input of pipelines that draw pieces with materials (shaders/material_vertex.glsl).
#pragma once

#include <cstddef>

#include <vulkan/vulkan.h>

#include "engine/gpu/pipeline.h"
#include "engine/render/scene.h"
#include "shaders/shared.h"

namespace brittle::engine {

// Positions, normals, attributes of corners.
inline constexpr VkVertexInputBindingDescription material_bindings[] = {
    {0, sizeof(glm::vec3), VK_VERTEX_INPUT_RATE_VERTEX},
    {1, sizeof(glm::vec3), VK_VERTEX_INPUT_RATE_VERTEX},
    {2, sizeof(CornerLook), VK_VERTEX_INPUT_RATE_VERTEX}};
inline constexpr VkVertexInputAttributeDescription material_attributes[] = {
    {0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0},
    {1, 1, VK_FORMAT_R32G32B32_SFLOAT, 0},
    {2, 2, VK_FORMAT_R32G32_SFLOAT, offsetof(CornerLook, uv)},
    {3, 2, VK_FORMAT_R8G8B8A8_UNORM, offsetof(CornerLook, colour)},
    {4, 2, VK_FORMAT_R32_UINT, offsetof(CornerLook, material)}};

// Pipelines for the view of materials, made by the first frame that needs them.
struct MaterialPipelines {
    Pipeline solid, cut_out; // of solid pieces; `cut_out` discards pixels, and is without the early depth test
    Pipeline fading;         // of fading pieces, cut out or not
};

// The specialization constants of shaders that cut out materials.
struct CutOutConstants {
    VkBool32 values[2]; // fading, cut out
    VkSpecializationMapEntry entries[2] = {{shared::constant_fading, 0, sizeof(VkBool32)},
                                           {shared::constant_cut_out, sizeof(VkBool32), sizeof(VkBool32)}};
    VkSpecializationInfo info{2, entries, sizeof values, values};

    explicit CutOutConstants(bool fading) : values{fading, VK_TRUE} {}
    CutOutConstants(const CutOutConstants&) = delete; // `info` points to the other members
    CutOutConstants& operator=(const CutOutConstants&) = delete;
};

} // namespace brittle::engine
