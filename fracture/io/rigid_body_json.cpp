#include "fracture/io/rigid_body_json.h"

#include <glm/gtc/quaternion.hpp>

#include "fracture/mesh/principal_axes.h"

namespace brittle::fracture {

nlohmann::ordered_json rigid_body_json(const MassProperties& mass, double density, std::optional<size_t> hull) {
    const PrincipalAxes principal = principal_axes(mass.inertia);
    const glm::dquat turn = glm::normalize(glm::quat_cast(principal.axes));
    const glm::dvec3 moments = principal.moments * density;
    nlohmann::ordered_json json;
    json["motion"] = {{"mass", mass.volume * density},
                      {"inertiaDiagonal", {moments.x, moments.y, moments.z}},
                      {"inertiaOrientation", {turn.x, turn.y, turn.z, turn.w}}};
    if (hull) json.update(collider_json(*hull));
    return json;
}

nlohmann::ordered_json collider_json(size_t hull) {
    nlohmann::ordered_json json;
    json["collider"]["geometry"] = {{"node", hull}, {"convexHull", true}};
    return json;
}

} // namespace brittle::fracture
