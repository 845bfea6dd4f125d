#include "engine/camera/view_volume.h"

#include "shaders/frustum.h"

namespace brittle::engine {

ViewVolume::ViewVolume(const Camera& camera, float aspect) {
    const CameraMatrices m = matrices(camera, aspect, {});
    clip_from_world_ = m.projection * m.view;
    // Replaces the depth row by half of the w row: every point in front of the eye has depth 0.5, within the depth
    // range.
    for (int column = 0; column < 4; ++column) clip_from_world_[column][2] = 0.5f * clip_from_world_[column][3];
}

bool ViewVolume::sees(const glm::vec3& from, const glm::vec3& to, float radius) const {
    return shared::intersects_frustum(clip_from_world_, from, to, radius);
}

} // namespace brittle::engine
