#include "fracture/pieces/certificate.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/mesh/manifold_check.h"
#include "fracture/mesh/mass_properties.h"

namespace brittle::fracture {
namespace {

constexpr uint32_t min_pieces = 4; // per run

// The verified properties of one piece.
struct PieceFacts {
    bool well_formed = false; // ranges and indices are within their arrays
    bool solid = false;       // closed, oriented and manifold
    double volume = 0.0;
};

bool is_within(const Range& range, size_t size) {
    return range.begin <= range.end && range.end <= size;
}

// Checks all indices before they are used: a certificate does not trust its input.
bool is_well_formed(const Fragments& fragments, const Piece& piece) {
    if (!is_within(piece.vertices, fragments.positions.size())) return false;
    if (!is_within(piece.triangles, fragments.triangles.size())) return false;
    if (piece.exterior_triangles > piece.triangles.size()) return false;
    const uint32_t vertices = piece.vertices.size();
    return std::ranges::all_of(fragments.triangles_of(piece), [vertices](const Triangle& t) {
        return t.x < vertices && t.y < vertices && t.z < vertices;
    });
}

void check_pieces(const Fragments& fragments, uint32_t first, uint32_t last, std::vector<PieceFacts>& facts) {
    ManifoldCheck check;
    Threads alone;
    for (uint32_t p = first; p < last; ++p) {
        const Piece& piece = fragments.pieces[p];
        if (!is_well_formed(fragments, piece)) continue;
        const auto positions = fragments.positions_of(piece);
        const auto triangles = fragments.triangles_of(piece);
        facts[p] = {true, !triangles.empty() && check.run(positions.size(), triangles, alone),
                    signed_volume(positions, triangles)};
    }
}

uint32_t count_distinct(std::vector<uint32_t> values) {
    std::sort(values.begin(), values.end());
    return static_cast<uint32_t>(std::unique(values.begin(), values.end()) - values.begin());
}

class Hasher {
  public:
    void add(uint64_t word) {
        state_ = (state_ ^ word) * 0x100000001b3ull;
        // Multiplication carries upwards only; this folds the high bits of a word (sign, exponent) back down.
        state_ ^= state_ >> 32;
    }
    // Adding +0 turns -0 into +0 and leaves every other number unchanged.
    void add(double value) { add(std::bit_cast<uint64_t>(value + 0.0)); }
    void add(uint32_t low, uint32_t high) { add(low | static_cast<uint64_t>(high) << 32); }

    [[nodiscard]] uint64_t value() const { return state_; }

  private:
    uint64_t state_ = 0xcbf29ce484222325ull;
};

} // namespace

Certificate certify(const TriangleMesh& input, const Fragments& fragments, uint32_t thread_count) {
    Certificate certificate;
    const auto count = static_cast<uint32_t>(fragments.pieces.size());
    certificate.pieces = count;
    certificate.triangles_in = input.triangles.size();
    certificate.triangles_out = fragments.triangles.size();

    // The hash and the volume of the input are tasks of their own, beside the runs of pieces.
    std::vector<PieceFacts> facts(count);
    Threads threads(thread_count);
    const uint32_t runs = threads.chunks(count, min_pieces);
    threads.for_each(runs + 2, [&](uint32_t task) {
        if (task == 0) {
            certificate.hash = hash(fragments);
        } else if (task == 1) {
            certificate.volume_input = signed_volume(input.positions, input.triangles);
        } else {
            const auto first = static_cast<uint32_t>(uint64_t{count} * (task - 2) / runs);
            const auto last = static_cast<uint32_t>(uint64_t{count} * (task - 1) / runs);
            check_pieces(fragments, first, last, facts);
        }
    });

    std::vector<uint32_t> sites;
    sites.reserve(count);
    double smallest = std::numeric_limits<double>::infinity();
    for (uint32_t p = 0; p < count; ++p) { // in index order, so that sums do not depend on the threads
        const Piece& piece = fragments.pieces[p];
        sites.push_back(piece.site);
        certificate.open_pieces += facts[p].solid ? 0 : 1;
        if (!facts[p].well_formed) continue;
        certificate.cap_triangles += piece.triangles.size() - piece.exterior_triangles;
        certificate.volume_sum += facts[p].volume;
        certificate.negative_pieces += facts[p].volume > 0.0 ? 0 : 1;
        smallest = std::min(smallest, facts[p].volume);
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
