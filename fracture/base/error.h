// Errors that a caller must expect: bad files, bad meshes, bad settings. A bug in Brittle asserts instead.
//
// Result<T> holds either a T or an Error. Check it before use:
//
//     Result<TriangleMesh> mesh = import_mesh("bunny.obj");
//     if (!mesh) { std::fputs(mesh.error().message.c_str(), stderr); return 1; }
//     use(*mesh);
#pragma once

#include <string>

#include "fracture/base/result.h"

namespace brittle::fracture {

enum class Status {
    file_not_found,     // the file does not exist, or may not be read
    unsupported_format, // no reader or writer has this file extension
    malformed_file,     // the content of the file is damaged, truncated or of another format than the extension says
    empty_mesh,         // the mesh has no triangles
    invalid_mesh,       // a coordinate is not finite or too large, an index out of range, a vertex repeated
    not_closed,         // an edge belongs to one triangle only
    non_manifold,       // an edge belongs to three triangles or more, or a vertex to several fans
    not_oriented,       // adjacent triangles have opposite orientations
    inside_out,         // the enclosed volume is negative: the triangles face inwards
    no_volume,          // the enclosed volume is zero up to rounding
    inverted_part,      // the enclosed volume is positive, but a piece has negative volume
    lost_volume,        // the pieces miss a part of the enclosed volume that is larger than rounding
    invalid_sites,      // there are no sites, or a site is not finite or too far away
    invalid_setting,    // a setting is outside its documented range
    cancelled,          // Settings::cancelled returned true
    write_failed        // the output could not be written; an existing file is unchanged
};

// Returns the name of the status, for example "malformed_file". The string is static.
[[nodiscard]] constexpr const char* to_string(Status status) {
    switch (status) {
    case Status::file_not_found:
        return "file_not_found";
    case Status::unsupported_format:
        return "unsupported_format";
    case Status::malformed_file:
        return "malformed_file";
    case Status::empty_mesh:
        return "empty_mesh";
    case Status::invalid_mesh:
        return "invalid_mesh";
    case Status::not_closed:
        return "not_closed";
    case Status::non_manifold:
        return "non_manifold";
    case Status::not_oriented:
        return "not_oriented";
    case Status::inside_out:
        return "inside_out";
    case Status::no_volume:
        return "no_volume";
    case Status::inverted_part:
        return "inverted_part";
    case Status::lost_volume:
        return "lost_volume";
    case Status::invalid_sites:
        return "invalid_sites";
    case Status::invalid_setting:
        return "invalid_setting";
    case Status::cancelled:
        return "cancelled";
    case Status::write_failed:
        return "write_failed";
    }
    return "unknown";
}

struct Error {
    Status status;
    std::string message; // for people: the fault, its place (file, line, index, value) and the remedy
};

// A T, or an Error; fracture/base/result.h documents its members. Result<void> holds success, or an Error.
template<class T>
class [[nodiscard]] Result : public BasicResult<T, Error> {
  public:
    using BasicResult<T, Error>::BasicResult;
};

} // namespace brittle::fracture
