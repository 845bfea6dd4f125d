#include <cstdio>
#include <string>

#include "fracture/io/bytes.h"
#include "fracture/io/readers.h"

namespace brittle::fracture {
namespace {

// A file is a tree of chunks: two bytes of type, four bytes of length including this header, then content or children.
enum Kind : uint16_t {
    main_chunk = 0x4D4D,
    editor = 0x3D3D,
    object = 0x4000, // a zero-terminated name precedes the children
    triangle_mesh = 0x4100,
    vertex_list = 0x4110,
    face_list = 0x4120
};
constexpr size_t head_size = 6;

struct Chunk {
    uint16_t kind = 0;
    size_t begin = 0; // of the content, from the start of the file
    size_t end = 0;
};

class Reader3ds {
  public:
    explicit Reader3ds(std::span<const std::byte> bytes) : bytes_(bytes) {}

    Result<TriangleMesh> read() {
        if (bytes_.size() < head_size || load<uint16_t>(bytes_, 0) != main_chunk) {
            return Error{Status::malformed_file, "not a 3DS file: it does not start with the bytes 4D 4D"};
        }
        // Where the length of the main chunk differs from that of the file, the file decides: exporters write wrong
        // lengths.
        const Result<void> done = for_each_chunk({main_chunk, head_size, bytes_.size()}, [&](const Chunk& part) {
            return part.kind == editor ? read_editor(part) : Result<void>();
        });
        if (!done) return done.error();
        return std::move(mesh_);
    }

  private:
    template<class Visit>
    Result<void> for_each_chunk(const Chunk& parent, Visit visit) {
        size_t at = parent.begin;
        while (parent.end - at >= head_size) {
            const auto kind = load<uint16_t>(bytes_, at);
            const auto length = load<uint32_t>(bytes_, at + 2);
            if (length < head_size || length > parent.end - at) {
                return malformed(kind, at,
                                 "claims " + std::to_string(length) + " bytes where " + std::to_string(parent.end - at)
                                     + " are left");
            }
            if (Result<void> done = visit(Chunk{kind, at + head_size, at + length}); !done) return done;
            at += length;
        }
        return {};
    }

    Result<void> read_editor(const Chunk& chunk) {
        return for_each_chunk(chunk, [&](const Chunk& part) -> Result<void> {
            if (part.kind != object) return {};
            size_t begin = part.begin;
            while (begin < part.end && bytes_[begin] != std::byte{0}) ++begin;
            if (begin == part.end)
                return malformed(part.kind, part.begin - head_size, "has a name without a terminating zero");
            return for_each_chunk({part.kind, begin + 1, part.end}, [&](const Chunk& content) {
                return content.kind == triangle_mesh ? read_mesh(content) : Result<void>();
            });
        });
    }

    Result<void> read_mesh(const Chunk& chunk) {
        // The faces may precede the vertices that they refer to.
        Chunk vertices;
        Chunk faces;
        const Result<void> walked = for_each_chunk(chunk, [&](const Chunk& part) -> Result<void> {
            if (part.kind == vertex_list) vertices = part;
            if (part.kind == face_list) faces = part;
            return {};
        });
        if (!walked) return walked;

        const Result<uint32_t> vertex_count = count_of(vertices, 12);
        if (!vertex_count) return vertex_count.error();
        const Result<uint32_t> face_count = count_of(faces, 8);
        if (!face_count) return face_count.error();

        const auto base = static_cast<uint32_t>(mesh_.positions.size());
        for (uint32_t v = 0; v < *vertex_count; ++v) {
            const size_t at = vertices.begin + 2 + v * size_t{12};
            mesh_.positions.emplace_back(load<float>(bytes_, at), load<float>(bytes_, at + 4),
                                         load<float>(bytes_, at + 8));
        }
        for (uint32_t f = 0; f < *face_count; ++f) {
            Triangle triangle{0};
            for (int k = 0; k < 3; ++k) {
                const auto index = load<uint16_t>(bytes_, faces.begin + 2 + f * size_t{8} + k * size_t{2});
                if (index >= *vertex_count) {
                    return malformed(faces.kind, faces.begin - head_size,
                                     "has a face " + std::to_string(f) + " that names vertex " + std::to_string(index)
                                         + " of " + std::to_string(*vertex_count));
                }
                triangle[k] = base + index;
            }
            mesh_.triangles.push_back(triangle);
        }
        return {};
    }

    // Returns the number of elements at the start of a list, after checking that they fit. 0 where there is no such
    // chunk.
    Result<uint32_t> count_of(const Chunk& list, size_t element_size) const {
        if (list.kind == 0) return 0u;
        const size_t size = list.end - list.begin;
        const uint32_t count = size >= 2 ? load<uint16_t>(bytes_, list.begin) : 0;
        if (size < 2 + count * element_size) {
            return malformed(list.kind, list.begin - head_size,
                             "lists " + std::to_string(count) + " elements but is too short for them");
        }
        return count;
    }

    static Error malformed(uint16_t kind, size_t at, const std::string& what) {
        char name[8];
        std::snprintf(name, sizeof(name), "%04X", kind);
        return {Status::malformed_file, std::string("chunk ") + name + " at byte " + std::to_string(at) + " " + what
                                            + "; the file was cut short or is damaged"};
    }

    std::span<const std::byte> bytes_;
    TriangleMesh mesh_;
};

} // namespace

Result<TriangleMesh> read_3ds(std::span<const std::byte> bytes) {
    return Reader3ds(bytes).read();
}

} // namespace brittle::fracture
