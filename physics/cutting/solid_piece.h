// One piece of a breakable object, with all that physics and a renderer need of it: made once, on any thread, then
// shared and never changed.
//
//     Result<std::shared_ptr<const SolidPiece>> whole = make_solid(mesh, {.material = stone});
//     Result<std::vector<std::shared_ptr<const SolidPiece>>> pieces = break_solid(**whole, sites, groups, settings);
//
// Coordinates are those of the unbroken object for all its pieces, however often they were broken; double where they are
// cut again, float and relative to the centre of mass where they are drawn. Metres. Pure functions, for worker threads;
// results depend on neither threads nor clocks.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "physics/bonds/anchor.h"
#include "physics/bonds/held_blocks.h"
#include "physics/cutting/convex_parts.h"
#include "physics/material.h"
#include "physics/world/piece_mass.h"

namespace brittle::physics {

struct SolidSettings {
    Material material{};
    // m, cube root of volume: no smaller piece is made but where it hangs together with nothing, and what is smaller than
    // two of them is not cut.
    double min_size = 0.05;
    std::vector<AnchorRegion> anchors{}; // in the object's coordinates: a piece that reaches into one is fixed
    ConvexPartSettings parts{};
    HeldBlockSettings blocks{}; // of what is held and breakable
    uint32_t threads = 1;       // of one fracture; a Destruction's jobs cut on one each
};

struct SolidPiece {
    fracture::TriangleMesh mesh{};      // closed; without positions where it cannot be broken, the triangles stay
    uint32_t exterior_triangles = 0;    // the first so many are of the unbroken object's surface
    std::vector<uint32_t> source{};     // of each exterior triangle, the one of the unbroken object that it is part of
    std::vector<glm::vec3> positions{}; // of the vertices, relative to the centre of mass, for drawing
    fracture::MassProperties mass{};    // at density 1
    BodyMass body{};                    // kg
    std::vector<BodyPart> parts{};      // relative to the centre of mass
    float radius = 0.0f;                // m, around the centre of mass
    double bearable = 0.0;              // N s; a blow above it breaks the piece: see bearable_impulse()
    bool anchored = false;
    bool breakable = false;
    std::shared_ptr<const HeldBlocks> blocks{}; // for loads: of what is anchored and breakable; or null
};

using SolidPtr = std::shared_ptr<const SolidPiece>;

// What a solid bears of a blow as of a kilogram, N s: toughness(material) times its section across the longest side of its
// box, volume / side. Of a cube it is that of Structure's pieces, less for panes and needles.
[[nodiscard]] double bearable_impulse(const Material& material, double volume, const fracture::Box& box);

// An unbroken object. Fails as fracture() does on a mesh that cannot be broken, and on a material or a least size that is
// none.
[[nodiscard]] fracture::Result<SolidPtr> make_solid(const fracture::TriangleMesh& mesh,
                                                    const SolidSettings& settings = {});

// Cuts a solid along the cells of sites; cells of one group stay together where they touch. Pieces in the order of
// fracture(). Volumes sum to the solid's. Collision parts are the hulls of cells: none of a piece overlaps one of
// another but where islands of one cell do. Fails as fracture() does; Status::cancelled where `cancelled` says so.
[[nodiscard]] fracture::Result<std::vector<SolidPtr>>
break_solid(const SolidPiece& solid, std::span<const glm::dvec3> sites, std::span<const uint32_t> groups,
            const SolidSettings& settings, const std::function<bool()>& cancelled = {});

// Cuts a solid along those of its blocks that are in different islands (overloaded(), knocked_loose()). Islands of less
// than the least size join a neighbour. One piece where nothing is left to cut; else as break_solid().
[[nodiscard]] fracture::Result<std::vector<SolidPtr>> break_apart(const SolidPiece& solid,
                                                                  std::span<const uint32_t> islands,
                                                                  const SolidSettings& settings,
                                                                  const std::function<bool()>& cancelled = {});

// A piece of a fracture as it is, with one collision hull; source triangles are those of the fracture's input.
[[nodiscard]] SolidPtr solid_of(const fracture::Fragments& fragments, const fracture::Piece& piece,
                                const SolidSettings& settings);
// All of them, made side by side on so many threads (0: one a core). `hollow`: with as many collision hulls as their
// shape asks for, as an unbroken object has. Fails as make_solid() does on settings that are none.
[[nodiscard]] fracture::Result<std::vector<SolidPtr>>
solids_of(const fracture::Fragments& fragments, const SolidSettings& settings, bool hollow, uint32_t threads = 0);

} // namespace brittle::physics
