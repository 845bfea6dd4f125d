#include "physics/solver/piece_solver.h"

#include <algorithm>
#include <cassert>

namespace brittle::physics {

namespace {

// Slower blows do not bounce, in m/s: Bullet's value.
constexpr float min_bounce_speed = 0.2f;

bool rests(const btCollisionObject& object) {
    return object.isStaticObject() || !object.isActive();
}

} // namespace

void PieceSolver::solve(std::span<BodyRecord* const> awake, std::span<const AnyManifold> manifolds,
                        fracture::Threads& threads) {
    rows_.solve(awake, manifolds,
                {.seconds = settings_.step,
                 .sweeps = static_cast<int>(settings_.solver_iterations),
                 .gravity = metres_to_bullet(settings_.gravity),
                 .separation_speed = settings_.separation_speed * bullet_units,
                 .min_bounce_speed = min_bounce_speed * bullet_units},
                threads);
    manifolds_ = manifolds;
    awake_.assign(awake.begin(), awake.end());
    contacts_.clear();
    told_ = Told::none;
}

std::span<const Contact> PieceSolver::solved_contacts() {
    if (told_ == Told::none) {
        report_solved();
        solved_count_ = contacts_.size();
        told_ = Told::solved;
    }
    return std::span(contacts_).first(solved_count_);
}

std::span<const Contact> PieceSolver::contacts(btDispatcher& dispatcher) {
    if (told_ != Told::all) {
        (void)solved_contacts();
        report_sleeping(dispatcher);
        told_ = Told::all;
    }
    return contacts_;
}

void PieceSolver::report_solved() {
    auto solved = rows_.solved().begin();
    for (const AnyManifold& manifold : manifolds_) {
        if (manifold.ground) {
            for (const GroundPoint& point : manifold.ground->points()) {
                if (point.impulse <= 0.0f) continue;
                contacts_.push_back(contact_on_ground(*manifold.ground, point, point.impulse, point.friction));
                contacts_.back().speed = point.speed / bullet_units;
            }
            continue;
        }
        for (const auto end = solved + manifold.count; solved != end; ++solved) {
            if (solved->impulse <= 0.0f) continue;
            Contact contact = contact_between(*solved->manifold, *solved->point);
            contact.point = metres_from_bullet(solved->position);
            contact.impulse = contact.blow = solved->impulse / bullet_units;
            contact.friction = metres_from_bullet(solved->friction);
            contact.gap = solved->distance / bullet_units;
            contact.speed = solved->speed / bullet_units;
            contacts_.push_back(contact);
        }
    }
    assert(solved == rows_.solved().end());
}

// That stays as it is until one of them wakes, comes or goes.
void PieceSolver::report_sleeping(btDispatcher& dispatcher) {
    if (!resting_known_ || not_resting_ != awake_) {
        resting_known_ = true;
        not_resting_ = awake_;
        resting_contacts_.clear();
        for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
            const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
            if (!rests(*manifold.getBody0()) || !rests(*manifold.getBody1())) continue;
            for (int p = 0; p < manifold.getNumContacts(); ++p) {
                const btManifoldPoint& point = manifold.getContactPoint(p);
                if (point.m_appliedImpulse <= 0.0f) continue;
                Contact contact = contact_between(manifold, point);
                contact.impulse = contact.blow = point.m_appliedImpulse / bullet_units;
                contact.friction = metres_from_bullet(point.m_lateralFrictionDir1 * point.m_appliedImpulseLateral1);
                resting_contacts_.push_back(contact);
            }
        }
        for (const GroundManifold* manifold : ground_.manifolds()) {
            if (manifold->count == 0 || !rests(*manifold->body)) continue;
            for (const GroundPoint& point : manifold->points())
                if (point.kept_impulse() > 0.0f)
                    resting_contacts_.push_back(
                        contact_on_ground(*manifold, point, point.kept_impulse(), point.kept_friction()));
        }
    }
    contacts_.insert(contacts_.end(), resting_contacts_.begin(), resting_contacts_.end());
}

Contact PieceSolver::contact_between(const btPersistentManifold& manifold, const btManifoldPoint& point) const {
    Contact contact;
    const int first = manifold.getBody0()->getUserIndex(), second = manifold.getBody1()->getUserIndex();
    assert(first >= 0 && second >= 0); // contacts with the ground are told from their own manifolds
    contact.a = bodies_[static_cast<size_t>(first)]->id;
    contact.b = bodies_[static_cast<size_t>(second)]->id;
    // Bullet's index is that of the hull in a compound, -1 without.
    contact.part_a = static_cast<uint32_t>(std::max(point.m_index0, 0));
    contact.part_b = static_cast<uint32_t>(std::max(point.m_index1, 0));
    // Where it acts on what moves.
    const bool b_moves = !manifold.getBody1()->isStaticObject();
    contact.point = metres_from_bullet(b_moves ? point.getPositionWorldOnB() : point.getPositionWorldOnA());
    contact.normal = to_glm(point.m_normalWorldOnB);
    contact.gap = point.getDistance() / bullet_units;
    return contact;
}

Contact PieceSolver::contact_on_ground(const GroundManifold& manifold, const GroundPoint& point, float impulse,
                                       float friction) const {
    Contact contact;
    contact.a = bodies_[static_cast<size_t>(manifold.body->getUserIndex())]->id;
    contact.part_a = static_cast<uint32_t>(std::max(manifold.hull, 0));
    contact.point = metres_from_bullet(unpacked(point.position));
    contact.normal = {0.0f, 1.0f, 0.0f};
    contact.impulse = contact.blow = impulse / bullet_units;
    contact.friction = metres_from_bullet(unpacked(point.along) * friction);
    contact.gap = point.distance / bullet_units;
    return contact;
}

} // namespace brittle::physics
