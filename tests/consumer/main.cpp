// Breaks a mesh into twenty pieces: consumer MESH
#include <cstdio>

#include <fracture/fracture.h>
#include <fracture/io/import.h>
#include <fracture/pieces/certificate.h>
#include <fracture/sites/sites.h>

namespace bf = brittle::fracture;

int main(int count, char** arguments) {
    if (count != 2) return std::puts("usage: consumer MESH"), 2;
    const bf::Result<bf::TriangleMesh> mesh = bf::import_mesh(arguments[1]);
    if (!mesh) return std::puts(mesh.error().message.c_str()), 1;

    const auto sites = bf::uniform_sites(bf::bounds(*mesh), 20, 1);
    const bf::Result<bf::Fragments> fragments = bf::fracture(*mesh, sites);
    if (!fragments) return std::puts(fragments.error().message.c_str()), 1;

    for (const bf::Piece& piece : fragments->pieces) {
        const glm::dvec3& at = piece.mass.centre_of_mass;
        std::printf("%6.3f m^3 at %6.3f %6.3f %6.3f, %u triangles\n", piece.mass.volume, at.x, at.y, at.z,
                    piece.triangles.size());
    }
    return bf::certify(*mesh, *fragments).closed ? 0 : 1;
}
