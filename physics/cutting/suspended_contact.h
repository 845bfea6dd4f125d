// The impulse of a contact that broke a piece, held back until the parts of the piece exist.
//
// The world solves a contact against the whole piece. Once the piece has broken, that impulse is wrong: it belongs
// between the striker and the one part that was hit. It is corrected in three steps:
//
//     suspend(world, piece, contact);               // at the contact: the striker stops instead of bouncing off
//     restore(world, piece, crack_share, contact);  // at the commit: both get the impulse back, less the cracks
//     ... the piece's body is replaced by those of its parts ...
//     solve_again(world, part, contact);            // a perfectly inelastic contact with the part that was hit
//
// Each step applies equal and opposite impulses at one point, so momentum and angular momentum are conserved. The
// energy that returns never exceeds the energy that the contact dissipated. A piece that is fixed takes no impulse:
// there the world is the other side of the exchange.
//
// World coordinates, SI units.
#pragma once

#include <glm/vec3.hpp>

#include "physics/world/world.h"

namespace brittle::physics {

struct SuspendedContact {
    BodyId striker{};
    glm::vec3 normal_impulse{0.0f};   // N s, on the piece; the striker got the opposite
    glm::vec3 friction_impulse{0.0f}; // N s, on the piece
    glm::vec3 arm{0.0f};              // m, from the striker's centre of mass to the contact at the time of contact
    double lost = 0.0;                // J that the contact dissipated, the limit of what restore() returns

    [[nodiscard]] bool empty() const; // no impulse along the normal
};

// Takes back the bounce: the part of the impulse that drives the two apart. The rest remains suspended.
void suspend(World& world, BodyId piece, SuspendedContact& contact);

// Adds the friction on the piece, and sets the energy that both impulses together cost piece and striker.
void add_friction(const World& world, BodyId piece, const glm::vec3& friction, SuspendedContact& contact);

// Undoes the suspended impulse, after cracks have taken `crack_share` of the blow's energy: a share f of the impulse
// returns f^2 of the energy. Where the bodies have moved so that the impulse would return more than `lost`, a smaller
// share of it is undone. Leaves in the contact the undone impulse; zero if either body is gone.
void restore(World& world, BodyId piece, double crack_share, SuspendedContact& contact);

// Solves the contact between the striker and a part as a perfectly inelastic one, with the suspended impulse as its
// limit and friction in proportion. Leaves in the contact the impulse and the energy of this solution.
void solve_again(World& world, BodyId part, SuspendedContact& contact);

} // namespace brittle::physics
