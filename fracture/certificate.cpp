#include "fracture/certificate.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "fracture/mass_properties.h"
#include "fracture/topology.h"

namespace brittle::fracture {
namespace {

bool is_within(const Range& range, size_t size) {
    return range.begin <= range.end && range.end <= size;
}

// A certificate does not trust what it certifies: indices are looked at before they are followed.
bool is_well_formed(const Fragments& fragments, const Piece& piece) {
    if (!is_within(piece.vertices, fragments.positions.size())) return false;
    if (!is_within(piece.triangles, fragments.triangles.size())) return false;
    if (piece.exterior_triangles > piece.triangles.size()) return false;
    const uint32_t vertices = piece.vertices.size();
    return std::ranges::all_of(fragments.triangles_of(piece), [vertices](const Triangle& t) {
        return t.x < vertices && t.y < vertices && t.z < vertices;
    });
}

uint32_t count_distinct(std::vector<uint32_t> values) {
    std::sort(values.begin(), values.end());
    return static_cast<uint32_t>(std::unique(values.begin(), values.end()) - values.begin());
}

class Hasher {
  public:
    void add(uint64_t word) {
        state_ = (state_ ^ word) * 0x100000001b3ull;
        // Multiplication carries upwards only; this brings the high bits of a word (sign, exponent) back
        // down.
        state_ ^= state_ >> 32;
    }
    // Adding +0 turns -0 into +0 and leaves every other number as it is.
    void add(double value) { add(std::bit_cast<uint64_t>(value + 0.0)); }
    void add(uint32_t low, uint32_t high) { add(low | static_cast<uint64_t>(high) << 32); }

    [[nodiscard]] uint64_t value() const { return state_; }

  private:
    uint64_t state_ = 0xcbf29ce484222325ull;
};

} // namespace

Certificate certify(const TriangleMesh& input, const Fragments& fragments) {
    Certificate certificate;
    certificate.pieces = static_cast<uint32_t>(fragments.pieces.size());
    certificate.triangles_in = input.triangles.size();
    certificate.triangles_out = fragments.triangles.size();
    certificate.volume_input = signed_volume(input.positions, input.triangles);
    certificate.hash = hash(fragments);

    std::vector<uint32_t> sites;
    sites.reserve(fragments.pieces.size());
    double smallest = std::numeric_limits<double>::infinity();
    for (const Piece& piece : fragments.pieces) {
        sites.push_back(piece.site);
        if (!is_well_formed(fragments, piece)) {
            ++certificate.open_pieces;
            continue;
        }
        const auto positions = fragments.positions_of(piece);
        const auto triangles = fragments.triangles_of(piece);
        const bool solid = !triangles.empty() && check_topology(positions.size(), triangles).manifold();
        certificate.open_pieces += solid ? 0 : 1;
        certificate.cap_triangles += piece.triangles.size() - piece.exterior_triangles;
        const double volume = signed_volume(positions, triangles);
        certificate.volume_sum += volume;
        smallest = std::min(smallest, volume);
    }
    certificate.cells = count_distinct(std::move(sites));
    certificate.closed = certificate.open_pieces == 0;
    certificate.smallest_piece = std::isfinite(smallest) ? smallest : 0.0;

    const double difference = std::abs(certificate.volume_sum - certificate.volume_input);
    const double scale = std::abs(certificate.volume_input);
    certificate.volume_error = scale > 0.0 ? difference / scale : difference;
    return certificate;
}

uint64_t hash(const Fragments& fragments) {
    Hasher hasher;
    hasher.add(uint64_t{fragments.positions.size()});
    hasher.add(uint64_t{fragments.triangles.size()});
    hasher.add(uint64_t{fragments.pieces.size()});
    for (const glm::dvec3& p : fragments.positions) {
        hasher.add(p.x);
        hasher.add(p.y);
        hasher.add(p.z);
    }
    for (const Triangle& t : fragments.triangles) {
        hasher.add(t.x, t.y);
        hasher.add(uint64_t{t.z});
    }
    for (const Piece& piece : fragments.pieces) {
        hasher.add(piece.site, piece.exterior_triangles);
        hasher.add(piece.vertices.begin, piece.vertices.end);
        hasher.add(piece.triangles.begin, piece.triangles.end);
    }
    return hasher.value();
}

} // namespace brittle::fracture
