#include "fracture/io/certificate_json.h"

#include <cinttypes>
#include <cstdio>

#include <nlohmann/json.hpp>

namespace brittle::fracture {

std::string certificate_json(const Certificate& c) {
    char hash[24];
    std::snprintf(hash, sizeof hash, "%016" PRIx64, c.hash);
    return nlohmann::ordered_json{{"cells", c.cells},
                                  {"pieces", c.pieces},
                                  {"closed", c.closed},
                                  {"open_pieces", c.open_pieces},
                                  {"negative_pieces", c.negative_pieces},
                                  {"volume_input", c.volume_input},
                                  {"volume_sum", c.volume_sum},
                                  {"volume_error", c.volume_error},
                                  {"smallest_piece", c.smallest_piece},
                                  {"triangles_in", c.triangles_in},
                                  {"triangles_out", c.triangles_out},
                                  {"cap_triangles", c.cap_triangles},
                                  {"hash", hash}}
        .dump();
}

} // namespace brittle::fracture
