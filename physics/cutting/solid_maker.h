// The steps that make solids, from meshes and from the pieces of a cut.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "physics/cutting/solid_piece.h"

namespace brittle::physics {

[[nodiscard]] inline double cube(double x) {
    return x * x * x;
}

// Fails with invalid_setting on an invalid material or minimum size.
[[nodiscard]] fracture::Result<void> check(const SolidSettings& settings);

// Fills in radius, body, bearable, anchored and breakable, from the surface or the clusters, and the mass.
void finish(SolidPiece& solid, const SolidSettings& settings);

// Makes the clusters of a large, breakable, connected solid.
void add_clusters(SolidPiece& solid, const SolidSettings& settings);

// Makes the blocks of an anchored, breakable solid.
void add_blocks(SolidPiece& solid, const SolidSettings& settings, const std::function<bool()>& cancelled = {});

// What a triangle lies on, in one number: the tag of its cluster.
namespace surface_tag {
inline constexpr uint32_t cut_bit = 0x80000000u;
[[nodiscard]] inline bool is_cut(uint32_t tag) {
    return (tag & cut_bit) != 0;
}
// The triangle of the unbroken object, or the number of the cut.
[[nodiscard]] inline uint32_t number(uint32_t tag) {
    return tag & ~cut_bit;
}
} // namespace surface_tag

// The tags of a surface's triangles.
[[nodiscard]] std::vector<uint32_t> tags_of(const SolidSurface& surface);

// Triangles with tags as a surface, exterior ones first.
[[nodiscard]] SolidSurface surface_of(fracture::TriangleMesh mesh, std::span<const uint32_t> tags,
                                      const glm::dvec3& centre_of_mass);

// Sets the surface of a solid whose mass is known.
void set_surface(SolidPiece& solid, fracture::TriangleMesh mesh, std::span<const uint32_t> tags);

// The tags of the triangles of a cut's pieces: those of the triangles that were cut, and a new number a site across a
// new cut.
class CutTags {
  public:
    // `of_input` are the tags of the triangles that were cut, of the solid `from`.
    CutTags(const fracture::Fragments& fragments, std::span<const uint32_t> of_input, const SolidPiece& from)
        : fragments_(fragments), of_input_(of_input), first_new_(from.cut_limit) {}

    [[nodiscard]] uint32_t of(uint32_t triangle, bool exterior) const {
        const uint32_t source = fragments_.triangle_source[triangle];
        return exterior ? of_input_[source] : (first_new_ + source) | surface_tag::cut_bit;
    }
    // Above all numbers of cuts of the pieces, of a cut by so many sites.
    [[nodiscard]] uint32_t limit(size_t sites) const { return first_new_ + static_cast<uint32_t>(sites); }

  private:
    const fracture::Fragments& fragments_;
    std::span<const uint32_t> of_input_;
    uint32_t first_new_;
};

// The solid of a piece of a cut, without parts.
[[nodiscard]] SolidPiece solid_from(const fracture::Fragments& fragments, const fracture::Piece& piece,
                                    const CutTags& tags, const SolidSettings& settings,
                                    const std::function<bool()>& cancelled);

// m^2 of the cracks between the pieces of a cut, whose cells have been joined: goes_to[cell] is the first cell of a
// piece.
[[nodiscard]] double crack_surface(const fracture::Fragments& cells, std::span<const uint32_t> goes_to);

// By cell of a cut: its collision hulls, relative to the cell's centre of mass. None for a cell of infinite volume, an
// open one (fracture/local/local_cut.h).
[[nodiscard]] std::vector<std::vector<BodyPart>>
parts_of_cells(const fracture::Fragments& cells, const ConvexPartSettings& settings, uint32_t threads = 1);

// Adds the hulls of a cell, whose centre of mass is given, to a piece.
void add_parts(const std::vector<BodyPart>& parts, const glm::dvec3& centre, SolidPiece& piece);

} // namespace brittle::physics
