// The debug lines of a World.
#include "physics/solver/world_impl.h"

namespace brittle::physics {

namespace {

constexpr float contact_line_length = 0.05f; // m

} // namespace

void World::debug_lines(std::vector<DebugLine>& out, const DebugDraw& draw) const {
    constexpr glm::vec3 awake_colour(1.0f, 0.1f, 0.1f), asleep_colour(0.35f, 0.05f, 0.05f);
    constexpr glm::vec3 contact_colour(1.0f, 0.85f, 0.1f);
    // Not through btIDebugDraw: its wireframe of a convex hull draws every edge twice, from features that it
    // finds anew or keeps in the shape, where they would take part in collisions.
    const auto draw_hull = [&](const btConvexHullShape& shape, std::vector<HullEdge>& edges, const btTransform& frame,
                               const glm::vec3& colour) {
        const btVector3* points = shape.getUnscaledPoints();
        if (edges.empty()) {
            std::vector<glm::vec3> corners;
            for (int p = 0; p < shape.getNumPoints(); ++p) corners.push_back(to_glm(points[p]));
            edges = hull_edges(corners);
        }
        for (const auto& [from, to] : edges)
            out.push_back({metres_from_bullet(frame * points[from]), metres_from_bullet(frame * points[to]), colour});
    };
    for (size_t i = 0; draw.hulls && i < impl_->bodies.size(); ++i) {
        BodyRecord& body = *impl_->bodies[i];
        const btTransform& frame = body.rigid->getWorldTransform();
        const glm::vec3 colour = body.awake() ? awake_colour : asleep_colour;
        if (!body.compound) draw_hull(*body.form->shape, body.edges, frame, colour);
        for (size_t part = 0; part < body.shared.size(); ++part)
            draw_hull(body.shared[part]->shape, body.shared[part]->edges,
                      frame * body.compound->getChildTransform(static_cast<int>(part)), colour);
    }
    const auto draw_contact = [&](const btVector3& at, const btVector3& normal, float distance) {
        if (distance >= touching_distance * bullet_units) return;
        const glm::vec3 from = metres_from_bullet(at);
        out.push_back({from, from + to_glm(normal) * contact_line_length, contact_colour});
    };
    for (int i = 0; draw.contacts && i < impl_->engine->dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold* manifold = impl_->engine->dispatcher.getManifoldByIndexInternal(i);
        for (int p = 0; p < manifold->getNumContacts(); ++p) {
            const btManifoldPoint& point = manifold->getContactPoint(p);
            draw_contact(point.getPositionWorldOnB(), point.m_normalWorldOnB, point.getDistance());
        }
    }
    if (!draw.contacts) return;
    for (const GroundManifold* manifold : impl_->engine->ground_contacts.manifolds())
        for (const GroundPoint& point : manifold->points())
            draw_contact(unpacked(point.position) - btVector3(0, point.distance, 0), {0, 1, 0}, point.distance);
}

} // namespace brittle::physics
