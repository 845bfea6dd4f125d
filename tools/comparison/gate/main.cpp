// The checks of tools/compare as a program.
//
//     compare_gate cells MESH SITES PARTS            Voronoi cells in a box around the mesh, for peers that intersect
//     compare_gate volumes MESH SITES FILE [N]       the volume of the solid in each cell; N: prisms in exact arithmetic
//     compare_gate check MESH SITES VOLUMES PIECES   one line of JSON about the pieces
//
// Exit 1 where a file cannot be read or written, 2 for a wrong command line.
#include <iomanip>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/comparison/gate/checks.h"
#include "tools/comparison/gate/oracle.h"

namespace brittle::comparison {

namespace {

constexpr uint64_t default_prisms = 20'000; // a minute at most

void write_volumes(const std::string& name, const CellVolumes& volumes) {
    std::ofstream out(name);
    out << std::setprecision(17) << "deviation " << volumes.deviation << '\n';
    for (const CellVolume& cell : volumes.cells) out << cell.volume << (cell.exact ? " exact\n" : " double\n");
    if (!out.flush()) throw std::runtime_error(name + ": cannot be written");
}

std::vector<double> read_volumes(const std::string& name) {
    std::ifstream in(name);
    std::string word;
    double value = 0.0;
    if (!(in >> word >> value)) throw std::runtime_error(name + ": cannot be read; make it with: compare_gate volumes");
    std::vector<double> volumes;
    while (in >> value >> word) volumes.push_back(value);
    return volumes;
}

void print(const Verdict& v) {
    std::cout << std::setprecision(6) << "{\"pieces\": " << v.pieces << ", \"piece_triangles\": " << v.triangles
              << ", \"open\": " << v.open << ", \"open_exactly\": " << v.open_exactly
              << ", \"crossing\": " << v.crossing << ", \"joined_islands\": " << v.joined_islands
              << ", \"negative\": " << v.negative << ", \"wrong_cells\": " << v.wrong_cells
              << ", \"worst_cell\": " << v.worst_cell << ", \"volume_error\": " << v.volume_error
              << ", \"wrong_caps\": " << v.wrong_caps << ", \"equal_caps\": " << v.equal_caps << ", \"reason\": \""
              << v.reason() << "\"}" << std::endl;
}

int run(const std::vector<std::string>& words) {
    const std::string task = words.empty() ? "" : words[0];
    if ((task != "cells" || words.size() != 4) && (task != "volumes" || words.size() < 4 || words.size() > 5)
        && (task != "check" || words.size() != 5)) {
        std::cerr << "usage: compare_gate cells MESH SITES PARTS\n"
                     "       compare_gate volumes MESH SITES FILE [PRISMS]\n"
                     "       compare_gate check MESH SITES VOLUMES PIECES\n";
        return 2;
    }
    const std::vector<Part> meshes = read_parts(words[1]);
    const std::vector<Point> sites = read_sites(words[2]);
    if (meshes.size() != 1 || meshes[0].triangles.empty())
        throw std::runtime_error(words[1] + ": must hold one part with triangles");
    if (sites.empty()) throw std::runtime_error(words[2] + ": holds no site");
    const Part& mesh = meshes[0];
    if (task == "cells") write_parts(words[3], voronoi_cells(mesh, sites));
    if (task == "volumes")
        write_volumes(words[3], cell_volumes(mesh, sites, words.size() > 4 ? std::stoull(words[4]) : default_prisms));
    if (task == "check") {
        const std::vector<double> volumes = read_volumes(words[3]);
        if (volumes.size() != sites.size())
            throw std::runtime_error(words[3] + ": has " + std::to_string(volumes.size()) + " volumes for "
                                     + std::to_string(sites.size())
                                     + " sites; make it again with: compare_gate volumes");
        print(Gate(mesh, sites, volumes).check(read_parts(words[4])));
    }
    return 0;
}

} // namespace

} // namespace brittle::comparison

int main(int count, char** words) {
    try {
        return brittle::comparison::run({words + 1, words + count});
    } catch (const std::exception& error) {
        std::cerr << "compare_gate: " << error.what() << '\n';
        return 1;
    }
}
