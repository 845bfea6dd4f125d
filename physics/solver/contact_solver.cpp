#include "physics/solver/contact_solver.h"

#include <algorithm>
#include <cassert>

namespace brittle::physics {

namespace {

// m/s; slower impacts do not bounce.
constexpr float min_bounce_speed = 0.2f;
// Sweeps of a substep's first and second solution. One sweep and more substeps hold up stacks that are twice as tall as
// more sweeps and fewer substeps do. The last second solution is the velocity that bodies keep, and gets more.
constexpr int first_sweeps = 1, second_sweeps = 1, last_sweeps = 4, bounce_sweeps = 10;
// Parts of an overlap that a step corrects, between moving bodies and with a static one. Larger ones shake heaps. The
// second is larger, because bodies above press what lies on the ground into it.
constexpr float push_part = 0.2f, static_push_part = 0.4f;

bool is_at_rest(const SweptProxy& proxy) {
    return !proxy.body || !proxy.body->awake();
}

} // namespace

void ContactSolver::solve(std::span<Body* const> awake, std::span<const AnyManifold> manifolds, Joints& joints,
                          fracture::Threads& threads) {
    const auto substeps = static_cast<int>(settings_.solver_substeps);
    const DebrisSolver::Step debris{.seconds = settings_.step,
                                    .gravity = settings_.gravity,
                                    .separation_speed = settings_.separation_speed,
                                    .min_bounce_speed = min_bounce_speed,
                                    .push_part = push_part,
                                    .static_push_part = static_push_part,
                                    .row_substeps = static_cast<float>(substeps)};
    debris_.choose(awake, manifolds);
    debris_.push_guests(debris);
    rows_.solve(debris_.other_bodies(), debris_.other_manifolds(), joints,
                {.seconds = settings_.step,
                 .substeps = {.count = substeps,
                              .first = first_sweeps,
                              .second = second_sweeps,
                              .last = last_sweeps,
                              .bounce = bounce_sweeps,
                              .seconds = settings_.step / static_cast<float>(substeps),
                              .gravity = settings_.gravity,
                              .push_part = push_part / static_cast<float>(substeps),
                              .static_push_part = static_push_part / static_cast<float>(substeps)},
                 .separation_speed = settings_.separation_speed,
                 .min_bounce_speed = min_bounce_speed},
                threads);
    debris_.solve(debris, threads);
    awake_.assign(awake.begin(), awake.end());
    contacts_.clear();
    reported_ = Reported::none;
}

std::span<const Contact> ContactSolver::solved_contacts() {
    if (reported_ == Reported::none) {
        report_solved();
        solved_count_ = contacts_.size();
        reported_ = Reported::solved;
    }
    return std::span(contacts_).first(solved_count_);
}

std::span<const Contact> ContactSolver::contacts() {
    if (reported_ != Reported::all) {
        (void)solved_contacts();
        report_sleeping();
        reported_ = Reported::all;
    }
    return contacts_;
}

void ContactSolver::report_solved() {
    report_solved(debris_.other_manifolds(), rows_.solved());
    report_solved(debris_.manifolds(), debris_.solved());
}

void ContactSolver::report_solved(std::span<const AnyManifold> manifolds, std::span<const RowSolver::Solved> all) {
    auto solved = all.begin();
    for (const AnyManifold& manifold : manifolds) {
        if (manifold.ellipsoids) {
            for (const EllipsoidPoint& point : manifold.ellipsoids->points()) {
                if (point.last.normal <= 0.0f) continue;
                contacts_.push_back(report_of(*manifold.ellipsoids, point));
                contacts_.back().speed = point.speed;
            }
            continue;
        }
        if (manifold.ground) {
            for (const GroundPoint& point : manifold.ground->points()) {
                if (point.last.normal <= 0.0f) continue;
                contacts_.push_back(report_of(*manifold.ground, point));
                contacts_.back().speed = point.speed;
            }
            continue;
        }
        for (const auto end = solved + manifold.count; solved != end; ++solved) {
            if (solved->impulse <= 0.0f) continue;
            Contact contact = report_of(*solved->manifold, *solved->point);
            contact.point = solved->position;
            contact.impulse = contact.blow = solved->impulse;
            contact.friction = solved->friction;
            contact.gap = solved->distance;
            contact.speed = solved->speed;
            contacts_.push_back(contact);
        }
    }
    assert(solved == all.end());
}

// Contacts between sleeping bodies are constant until a body wakes, is added or is removed.
void ContactSolver::report_sleeping() {
    if (!sleeping_known_ || were_awake_ != awake_) {
        sleeping_known_ = true;
        were_awake_ = awake_;
        sleeping_contacts_.clear();
        std::vector<AnyManifold> manifolds;
        for (const SweptPair& pair : broadphase_.pairs().all())
            if (pair.contacts && is_at_rest(*pair.a) && is_at_rest(*pair.b)) pair.contacts->collect(manifolds);
        for (const AnyManifold& manifold : manifolds) {
            if (manifold.ground) {
                for (const GroundPoint& point : manifold.ground->points())
                    if (point.last.normal > 0.0f) sleeping_contacts_.push_back(report_of(*manifold.ground, point));
                continue;
            }
            if (manifold.ellipsoids) {
                for (const EllipsoidPoint& point : manifold.ellipsoids->points())
                    if (point.last.normal > 0.0f) sleeping_contacts_.push_back(report_of(*manifold.ellipsoids, point));
                continue;
            }
            for (const ContactPoint& point : manifold.between->points()) {
                if (point.last.normal <= 0.0f) continue;
                Contact contact = report_of(*manifold.between, point);
                contact.impulse = contact.blow = point.last.normal;
                contact.friction = point.last.friction;
                sleeping_contacts_.push_back(contact);
            }
        }
    }
    contacts_.insert(contacts_.end(), sleeping_contacts_.begin(), sleeping_contacts_.end());
}

Contact ContactSolver::report_of(const Manifold& manifold, const ContactPoint& point) const {
    Contact contact;
    contact.a = manifold.a().id;
    contact.b = manifold.b().id;
    contact.part_a = point.part_a;
    contact.part_b = point.part_b;
    contact.point = (manifold.b().fixed ? point.on_a : point.on_b); // on a body that moves
    contact.normal = point.normal;
    contact.gap = point.distance;
    return contact;
}

Contact ContactSolver::report_of(const EllipsoidManifold& manifold, const EllipsoidPoint& point) const {
    Contact contact;
    contact.a = manifold.a->id;
    contact.b = manifold.b->id;
    contact.point = point.position;
    contact.normal = point.normal;
    contact.impulse = contact.blow = point.last.normal;
    contact.friction = point.last.friction;
    contact.gap = point.distance;
    return contact;
}

Contact ContactSolver::report_of(const GroundManifold& manifold, const GroundPoint& point) const {
    Contact contact;
    contact.a = manifold.body->id;
    contact.part_a = manifold.part;
    contact.point = point.position;
    contact.normal = {0.0f, 1.0f, 0.0f};
    contact.impulse = contact.blow = point.last.normal;
    contact.friction = point.last.friction;
    contact.gap = point.distance;
    return contact;
}

} // namespace brittle::physics
