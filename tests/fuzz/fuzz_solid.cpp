// Fuzzes what follows the reading of a mesh: weld, repair, union, fracture, export and import of the pieces. The bytes
// are a list of edits of a mesh, each of which leaves a readable mesh, so hardly any input is wasted on a parser.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <unistd.h>

#include "fracture/doctor/inspect.h"
#include "fracture/doctor/repair.h"
#include "fracture/fracture.h"
#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "fracture/io/weld.h"
#include "fracture/mesh/topology.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "fracture/unite/unite.h"
#include "tests/fuzz/oracle.h"

using namespace brittle;
using namespace brittle::fracture;

namespace {

constexpr size_t max_triangles = 200;

class Bytes {
  public:
    Bytes(const uint8_t* data, size_t size) : at_(data), end_(data + size) {}

    [[nodiscard]] bool empty() const { return at_ == end_; }
    uint32_t next() { return empty() ? 0 : *at_++; }
    uint32_t below(size_t n) { return n == 0 ? 0 : static_cast<uint32_t>((next() << 8 | next()) % n); }
    // On a lattice of eighths, where faces and edges coincide; now and then anywhere.
    double coordinate() {
        const uint32_t b = next();
        const double on_lattice = (static_cast<double>(b % 33) - 16.0) / 8.0;
        if (b < 200) return on_lattice;
        if (b < 230) return std::nextafter(on_lattice, 4.0);
        return on_lattice + (next() << 8 | next()) * 0x1p-20;
    }
    glm::dvec3 point() {
        const double x = coordinate(), y = coordinate();
        return {x, y, coordinate()};
    }

  private:
    const uint8_t *at_, *end_;
};

void append(TriangleMesh& mesh, const TriangleMesh& other, const glm::dvec3& scale, const glm::dvec3& offset) {
    const auto base = static_cast<uint32_t>(mesh.positions.size());
    for (const glm::dvec3& p : other.positions) mesh.positions.push_back(p * scale + offset);
    for (const Triangle& t : other.triangles) mesh.triangles.push_back(t + base);
}

TriangleMesh edited(Bytes& bytes) {
    TriangleMesh mesh;
    while (!bytes.empty() && mesh.triangles.size() < max_triangles) {
        const uint32_t edit = bytes.next() % 10;
        const uint32_t t = bytes.below(mesh.triangles.size()), v = bytes.below(mesh.positions.size());
        if (edit == 0 || mesh.triangles.empty()) {
            const glm::dvec3 scale = bytes.point();
            append(mesh, cube(1.0), scale, bytes.point());
        } else if (edit == 1) {
            append(mesh, icosphere(0), glm::dvec3(bytes.coordinate()), bytes.point());
        } else if (edit == 2) {
            append(mesh, torus(5, 4), glm::dvec3(bytes.coordinate()), bytes.point());
        } else if (edit == 3) {
            mesh.positions[v] = bytes.point();
        } else if (edit == 4) {
            mesh.triangles.erase(mesh.triangles.begin() + t);
        } else if (edit == 5) {
            std::swap(mesh.triangles[t].x, mesh.triangles[t].y);
        } else if (edit == 6) {
            mesh.triangles[t][static_cast<int>(bytes.next() % 3)] = v;
        } else if (edit == 7) {
            mesh.triangles.push_back({v, bytes.below(mesh.positions.size()), bytes.below(mesh.positions.size())});
        } else if (edit == 8) {
            mesh.positions[v] = mesh.positions[bytes.below(mesh.positions.size())];
        } else {
            mesh.triangles.push_back(Triangle(mesh.triangles[t]));
        }
    }
    return mesh;
}

// A folder of this process, removed at its end.
struct OwnFolder {
    OwnFolder() : path(std::filesystem::temp_directory_path() / ("brittle_fuzz_" + std::to_string(getpid()))) {
        std::filesystem::create_directories(path);
    }
    ~OwnFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
    std::filesystem::path path;
};

double absolute_volume(const Fragments& fragments) {
    double sum = 0.0;
    for (const Piece& piece : fragments.pieces) sum += std::abs(piece.mass.volume);
    return sum;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const fuzz::TimeGuard guard;
    Bytes bytes(data, size);
    std::vector<glm::dvec3> sites;
    for (uint32_t k = bytes.next() % 6 + 1; k > 0; --k) sites.push_back(bytes.point());
    const TriangleMesh mesh = weld(edited(bytes));
    if (mesh.triangles.empty()) return 0;
    static_cast<void>(describe(inspect(mesh)));

    const Repaired repaired = repair(mesh);
    const TopologyReport topology = check_topology(repaired.mesh.positions.size(), repaired.mesh.triangles);
    fuzz::require(topology.manifold(), "a repaired mesh is no closed manifold");
    fuzz::require(repair(repaired.mesh).mesh.triangles == repaired.mesh.triangles, "a second repair changes something");

    const United united = unite(repaired.mesh, 1);
    fuzz::require(check_topology(united.mesh.positions.size(), united.mesh.triangles).manifold(),
                  "a union is no closed manifold");
    if (united.report.complete)
        fuzz::require(unite(united.mesh, 1).mesh.positions == united.mesh.positions,
                      "a second union changes something");

    for (const TriangleMesh& solid : {repaired.mesh, united.mesh}) {
        if (solid.triangles.empty()) continue;
        const Result<Fragments> fragments = fracture::fracture(solid, sites, {.threads = 1});
        if (!fragments) {
            fuzz::check_message(fragments.error().message);
            continue;
        }
        const Certificate certificate = certify(solid, *fragments);
        fuzz::require(certificate.closed, "a piece is open");
        fuzz::require(std::abs(certificate.volume_sum - certificate.volume_input)
                          <= 1e-9 * (absolute_volume(*fragments) + std::abs(certificate.volume_input)) + 1e-12,
                      "volume is lost");
        static const OwnFolder folder;
        const auto files = export_pieces(folder.path / "pieces.glb", *fragments, certificate, {.sites = sites});
        if (!files) continue;
        const Result<Model> read = import_model(folder.path / "pieces.glb");
        fuzz::require(static_cast<bool>(read), "an exported file cannot be read");
    }
    return 0;
}
