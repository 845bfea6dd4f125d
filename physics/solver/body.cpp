#include "physics/solver/body.h"

#include <algorithm>
#include <utility>

#include "physics/solver/ellipsoid_contact.h"
#include "physics/solver/rotate4.h"
#include "physics/solver/time_of_impact.h"
#include "physics/world/world_check.h"

namespace brittle::physics {

namespace {

// The faces of a hull; nearly every hull holds them.
HullFaces faces_of(const CollisionHull& hull) {
    return hull.faces.count() == 0 ? hull_faces(hull.points) : hull.faces;
}

// Rotates the hull into the principal axes, the axes of the solver's frame. Precondition: to_principal is set.
HullShape shape_of(const BodyMeasures& body, const CollisionHull& hull, const glm::vec3& offset) {
    const glm::quat from_body = glm::conjugate(body.to_principal);
    const size_t count = hull.points.size();
    const auto at = [&](size_t i) { return hull.points[std::min(i, count - 1)] + offset; };
    std::vector<glm::vec3> points;
    points.reserve(count);
    for (size_t first = 0; first < count; first += 4) {
        const Vector4 four = rotated(from_body, Vector4::of(at(first), at(first + 1), at(first + 2), at(first + 3)));
        float x[4], y[4], z[4];
        four.x.store(x), four.y.store(y), four.z.store(z);
        for (size_t i = 0; i < std::min<size_t>(count - first, 4); ++i) points.push_back(glm::vec3(x[i], y[i], z[i]));
    }
    return {std::move(points), hull.margin, faces_of(hull)};
}

void measure(BodyMeasures& body, const HullShape& hull) {
    body.longest = hull.longest();
    body.reach = hull.radius();
    body.thickness = thickness(hull);
    body.squared_semi_axes = squared_semi_axes(hull.bounds({}), hull.volume());
}

void measure(BodyMeasures& body, const CompoundShape& compound) {
    const Bounds box = compound.bounds({});
    const glm::vec3 size = box.high - box.low;
    body.longest = std::max({size.x, size.y, size.z});
    body.reach = 0.0f;
    body.thickness = unbounded;
    float volume = 0.0f; // overlaps of hulls count twice
    for (const CompoundShape::Child& child : compound.children()) {
        body.reach = std::max(body.reach, glm::length(child.frame.origin) + child.shape().radius());
        body.thickness = std::min(body.thickness, thickness(child.shape()));
        volume += child.shape().volume();
    }
    body.squared_semi_axes = squared_semi_axes(box, volume);
}

// The cross section of a hull in its own axes; nearly every hull holds it.
CrossSection section_of(const CollisionHull& hull) {
    return hull.section.sides.empty() ? cross_section(hull.points) : hull.section;
}

AirDrag drag_of(const BodyMeasures& body, const CollisionHull& hull) {
    return {section_of(hull).sides, glm::conjugate(body.to_principal), body.mass, body.moments};
}

// Uses the sum of the hulls' cross sections or the cross section of their common box, whichever is smaller on average.
AirDrag drag_of(const BodyMeasures& body, const CompoundShape& compound, std::span<const BodyPart> parts) {
    std::vector<glm::vec3> all;
    for (const BodyPart& part : parts) {
        const CrossSection own = section_of(*part.hull);
        all.insert(all.end(), own.sides.begin(), own.sides.end());
    }
    CrossSection section = reduced(all);
    for (glm::vec3& side : section.sides) side = glm::conjugate(body.to_principal) * side;
    const Bounds bounds = compound.bounds({});
    const CrossSection around = section_of_box(glm::dvec3((bounds.high - bounds.low)) * 0.5,
                                               {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)});
    if (around.mean() < section.mean()) section = around;
    return {section.sides, glm::quat(1.0f, 0.0f, 0.0f, 0.0f), body.mass, body.moments};
}

bool has_one_hull(const BodyDesc& desc) {
    return desc.parts.size() <= 1;
}

// Offset of the only hull from the centre of mass.
glm::vec3 offset_of(const BodyDesc& desc) {
    return desc.parts.empty() ? glm::vec3(0.0f) : desc.parts[0].offset;
}

fracture::Error refused(std::string fault) {
    return {fracture::Status::invalid_setting, std::move(fault)};
}

// Fills the form, except for the shape of several hulls and the members computed from it. Returns what is wrong, or an
// empty string.
std::string describe(SolverForm& form, const BodyDesc& desc) {
    fracture::PrincipalAxes principal;
    if (std::string fault = fault_of_form(desc, principal); !fault.empty()) return fault;
    BodyMeasures& measures = form.measures;
    measures.to_principal = glm::normalize(glm::quat(glm::quat_cast(principal.axes)));
    measures.moments = principal.moments;
    measures.mass = desc.mass;
    measures.fixed = desc.fixed;
    if (!has_one_hull(desc)) return {};
    const CollisionHull& hull = desc.parts.empty() ? desc.hull : *desc.parts[0].hull;
    form.shape = shape_of(measures, hull, offset_of(desc));
    measure(measures, *form.shape);
    if (!desc.fixed) form.drag = drag_of(measures, hull);
    return {};
}

// A step sets the bounds of every moving body anew. Until then any bounds around the body will do, which saves a pass
// over its points. A body that is astray in its first step keeps these.
std::unique_ptr<SweptProxy> proxy_of(Body& body) {
    const glm::vec3 reach(body.reach);
    const Bounds bounds =
        body.fixed ? body.bounds(body.frame) : Bounds{body.frame.origin - reach, body.frame.origin + reach};
    return std::make_unique<SweptProxy>(SweptProxy{.body = &body, .bounds = bounds, .fixed = body.fixed});
}

// Sets mass, state and proxy. Precondition: the shape is set.
void finish(NewBody& made, const BodyDesc& desc, const WorldSettings& settings) {
    Body& body = *made.body;
    body.friction = desc.friction;
    body.restitution = desc.restitution;
    if (!body.fixed) {
        body.inverse_mass = 1.0f / body.mass;
        body.inverse_moments = 1.0f / (glm::vec3(body.moments));
    }
    body.set_frame(body.rewind_frame);
    body.velocity = body.solved;
    if (body.fixed)
        body.activity = Activity::asleep;
    else if (!settings.sleeping)
        body.activity = Activity::never_sleeps;
    body.debris = !body.fixed && (desc.debris || body.longest < settings.debris_size);
    body.cut = body.siblings = desc.siblings;
    made.proxy = proxy_of(body);
    body.proxy = made.proxy.get();
}

} // namespace

Result<std::shared_ptr<const BodyForm>> make_form(const BodyDesc& desc) {
    auto form = std::make_shared<SolverForm>();
    if (std::string fault = describe(*form, desc); !fault.empty()) return refused(std::move(fault));
    if (!has_one_hull(desc)) return std::shared_ptr<const BodyForm>();
    const CollisionHull& hull = desc.parts.empty() ? desc.hull : *desc.parts[0].hull;
    form->hull = {.points = hull.points, .margin = hull.margin};
    for (glm::vec3& point : form->hull.points) point += offset_of(desc);
    form->mass = desc.mass;
    form->inertia = desc.inertia;
    form->fixed = desc.fixed;
    return std::shared_ptr<const BodyForm>(std::move(form));
}

Result<NewBody> make_body(const BodyDesc& desc, const WorldSettings& settings) {
    NewBody made;
    made.body = std::make_unique<Body>();
    Body& body = *made.body;
    body.form = std::static_pointer_cast<const SolverForm>(desc.form); // make_form() makes no others
    if (!body.form) {
        auto form = std::make_shared<SolverForm>();
        if (std::string fault = describe(*form, desc); !fault.empty()) return refused(std::move(fault));
        body.form = std::move(form);
    }
    static_cast<BodyMeasures&>(body) = body.form->measures;
    if (std::string fault = fault_of_place(desc); !fault.empty()) return refused(std::move(fault));
    const glm::quat orientation = glm::normalize(desc.pose.orientation);
    body.rewind_frame = {matrix_of(orientation * body.to_principal), desc.pose.position};
    if (!body.fixed) body.solved = {desc.linear_velocity, desc.angular_velocity};
    body.unhindered = body.solved;
    if (desc.form || has_one_hull(desc)) finish(made, desc, settings);
    return made;
}

void finish_compound(NewBody& made, std::unique_ptr<CompoundShape> shape, const BodyDesc& desc,
                     const WorldSettings& settings) {
    Body& body = *made.body;
    body.compound = std::move(shape);
    measure(body, *body.compound);
    auto form = std::make_shared<SolverForm>();
    form->measures = body;
    if (!body.fixed) form->drag = drag_of(body, *body.compound, desc.parts);
    body.form = std::move(form);
    finish(made, desc, settings);
}

void Body::set_frame(const Transform& to) {
    frame = to;
    // R diag(1 / I) R^T
    const glm::mat3 scaled(to.basis[0] * inverse_moments.x, to.basis[1] * inverse_moments.y,
                           to.basis[2] * inverse_moments.z);
    inverse_inertia = scaled * glm::transpose(to.basis);
}

Mechanics mechanics_of(const Body& body, const glm::vec3& gravity) {
    if (body.fixed) return {};
    const double mass = 1.0 / static_cast<double>(body.inverse_mass);
    const glm::dvec3 position(body.frame.origin);
    const glm::dvec3 velocity(body.velocity.linear);
    const glm::dvec3 spin(body.velocity.angular);
    const glm::dquat orientation = glm::normalize(glm::dquat(rotation_of(body.frame.basis)));
    const glm::dvec3 angular = orientation * (body.moments * (glm::conjugate(orientation) * spin));
    return {.kinetic = 0.5 * (mass * glm::dot(velocity, velocity) + glm::dot(spin, angular)),
            .potential = -mass * glm::dot(glm::dvec3(gravity), position),
            .momentum = mass * velocity,
            .angular_momentum = angular + glm::cross(position, mass * velocity)};
}

} // namespace brittle::physics
