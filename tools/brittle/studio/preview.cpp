#include "tools/brittle/studio/preview.h"

#include <algorithm>
#include <utility>

#include <glm/geometric.hpp>

#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/pictures/picture.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/base/stopwatch.h"

namespace brittle::tools {

namespace {

constexpr float crack_lift = 0.004f; // m above the surface, so that the surface does not hide them
constexpr uint32_t crack_colour = engine::srgb8(52, 34, 28);
constexpr uint64_t max_coarse_triangles = 30'000; // that the roughness of a coarse preview adds, about
constexpr glm::vec3 falling_tint{1.5f, 0.42f, 0.12f};

// The edges between exterior and interior triangles of a piece. Each piece is closed, so an edge of an interior triangle
// has its twin in another interior triangle or in an exterior one.
void append_cracks(const Cracked& cracked, const fracture::Piece& piece, std::vector<engine::LineVertex>& lines) {
    const auto triangles = cracked.fragments.triangles_of(piece);
    const auto exterior = triangles.first(piece.exterior_triangles),
               interior = triangles.subspan(piece.exterior_triangles);
    std::vector<uint64_t> edges;
    const auto directed = [](uint32_t a, uint32_t b) { return uint64_t{a} << 32 | b; };
    for (const fracture::Triangle& t : interior)
        for (int k = 0; k < 3; ++k) edges.push_back(directed(t[k], t[(k + 1) % 3]));
    std::sort(edges.begin(), edges.end());
    const auto at = [&](uint32_t v) { return cracked.positions[piece.vertices.begin + v]; };
    std::vector<glm::vec3> normals(piece.vertices.size(), glm::vec3(0.0f));
    for (const fracture::Triangle& t : exterior) {
        const glm::vec3 across = glm::cross(at(t.y) - at(t.x), at(t.z) - at(t.x));
        for (int k = 0; k < 3; ++k) normals[t[k]] += across;
    }
    const auto lifted = [&](uint32_t v) {
        const float length = glm::length(normals[v]);
        return at(v) + (length > 0.0f ? crack_lift / length * normals[v] : glm::vec3(0.0f));
    };
    for (const uint64_t edge : edges) {
        const auto a = static_cast<uint32_t>(edge >> 32), b = static_cast<uint32_t>(edge);
        if (std::binary_search(edges.begin(), edges.end(), directed(b, a))) continue;
        lines.push_back({lifted(a), crack_colour});
        lines.push_back({lifted(b), crack_colour});
    }
}

void mark_what_stays(Cracked& cracked) {
    const auto& pieces = cracked.fragments.pieces;
    cracked.stays.assign(pieces.size(), 0);
    const auto largest = std::max_element(pieces.begin(), pieces.end(),
                                          [](const auto& a, const auto& b) { return a.mass.volume < b.mass.volume; });
    if (largest != pieces.end()) cracked.stays[static_cast<size_t>(largest - pieces.begin())] = 1;
}

std::vector<uint32_t> without_piece(const fracture::Fragments& fragments, size_t sites) {
    std::vector<uint8_t> owns(sites, 0);
    for (const fracture::Piece& piece : fragments.pieces) owns[piece.site] = 1;
    std::vector<uint32_t> idle;
    for (uint32_t s = 0; s < sites; ++s)
        if (!owns[s]) idle.push_back(s);
    return idle;
}

engine::PieceBatch batch_of(const Cracked& cracked) {
    std::vector<engine::PieceMesh> meshes;
    for (size_t p = 0; p < cracked.fragments.pieces.size(); ++p) {
        const fracture::Piece& piece = cracked.fragments.pieces[p];
        const glm::vec3 tint = cracked.stays.empty() ? engine::piece_tint(static_cast<uint32_t>(p))
                                                     : (cracked.stays[p] ? glm::vec3(1.0f) : falling_tint);
        meshes.push_back(
            {.positions = std::span(cracked.positions).subspan(piece.vertices.begin, piece.vertices.size()),
             .triangles = cracked.fragments.triangles_of(piece),
             .exterior_triangles = piece.exterior_triangles,
             .tint = tint});
    }
    return must(engine::PieceBatch::create(meshes));
}

// A coarse preview shows the largest bumps alone.
fracture::Roughness shown_roughness(const PreviewRequest& request) {
    fracture::Roughness rough = roughness_of(request.recipe, request.object->scale());
    if (!request.coarse) return rough;
    rough.detail = 1;
    rough.max_triangles = max_coarse_triangles;
    return rough;
}

} // namespace

void Preview::request(PreviewRequest request) {
    worker_.run([this, request = std::move(request)](const Worker::Cancelled& cancelled) {
        std::shared_ptr<Cracked> made = make(request, cancelled);
        const std::scoped_lock lock(mutex_);
        finished_ = std::move(made);
    });
}

bool Preview::busy() const {
    if (worker_.busy()) return true; // checked first: a worker that is no longer busy has stored its result
    const std::scoped_lock lock(mutex_);
    return finished_ != nullptr;
}

std::shared_ptr<Cracked> Preview::take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(finished_, nullptr);
}

// Fractures by the recipe, with the aimed strike added.
void Preview::fracture(const PreviewRequest& request, const Worker::Cancelled& cancelled, Cracked& made) {
    FractureOptions recipe = request.recipe;
    if (request.ghost) recipe.strikes.push_back(*request.ghost);
    SiteSet set = request.object->sites(recipe);
    const fracture::TriangleMesh& mesh = request.object->mesh();
    // Always the exact algorithm: the sequential one may take minutes, and its pieces look the same.
    const fracture::Settings settings{.threads = recipe.threads,
                                      .groups = set.groups,
                                      .weights = set.weights,
                                      .min_volume = recipe.min_volume,
                                      .rough = shown_roughness(request),
                                      .cancelled = cancelled};
    const Stopwatch stopwatch;
    must(fracture::fracture(mesh, set.sites, settings, workspace_, made.fragments));
    made.milliseconds = stopwatch.milliseconds();
    if (!recipe.strikes.empty()) {
        mark_what_stays(made);
        return;
    }
    // Merged pieces keep the site of only one of them, so that sites without pieces cannot be found.
    if (set.groups.empty() && !(recipe.min_volume > 0.0))
        made.idle_sites = without_piece(made.fragments, set.sites.size());
    made.cells = cell_lines(mesh, set.sites, set.weights);
    made.sites = std::move(set.sites);
}

void Preview::foresee_blow(const PreviewRequest& request, const Worker::Cancelled& cancelled, Cracked& made) {
    const Stopwatch stopwatch;
    Foreseen foreseen =
        request.cut ? foresee(*request.cut, cancelled)
                    : foresight_.of_whole(request.object, request.recipe, request.version, *request.blow, cancelled);
    made.milliseconds = stopwatch.milliseconds();
    made.fragments = std::move(foreseen.fragments);
    for (const uint8_t falls : foreseen.falls) made.stays.push_back(falls ? 0 : 1);
}

std::shared_ptr<Cracked> Preview::make(const PreviewRequest& request, const Worker::Cancelled& cancelled) {
    auto made = std::make_shared<Cracked>();
    made->key = request.key;
    made->ghost = request.ghost || request.blow || request.cut;
    made->piece = request.piece;
    try {
        if (request.blow || request.cut)
            foresee_blow(request, cancelled, *made);
        else
            fracture(request, cancelled, *made);
        made->pieces = static_cast<uint32_t>(made->fragments.pieces.size());
        made->positions.assign(made->fragments.positions.begin(), made->fragments.positions.end());
        for (size_t p = 0; p < made->fragments.pieces.size(); ++p)
            if (made->stays.empty() || !made->stays[p]) append_cracks(*made, made->fragments.pieces[p], made->cracks);
        if (request.cut) {
            const glm::vec3 centre(request.cut->solid->mass.centre_of_mass);
            for (engine::LineVertex& v : made->cracks) v.position -= centre;
        } else {
            made->batch = batch_of(*made);
            renderer_.stage(made->batch);
        }
    } catch (const Failure& failure) {
        made->fragments = {};
        made->fault = failure.what();
    }
    return made;
}

} // namespace brittle::tools
