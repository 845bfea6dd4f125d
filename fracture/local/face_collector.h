// Collects triangles of clusters in a FaceList.
//
//     FaceCollector taken(faces, numbers);
//     taken.open(*cluster);
//     taken.add(k); // its triangle k
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "fracture/local/cluster_mesh.h"
#include "fracture/local/number_table.h"

namespace brittle::fracture {

// Collects faces of one cluster after the other; each vertex once, by its number.
class FaceCollector {
  public:
    FaceCollector(FaceList& faces, NumberTable& numbers) : faces_(faces), numbers_(numbers) {}

    void open(const Cluster& cluster) {
        cluster_ = &cluster;
        local_.fill(no_index);
    }
    Triangle add(size_t k) {
        Triangle triangle;
        for (int c = 0; c < 3; ++c) triangle[c] = vertex(cluster_->triangles[k][static_cast<size_t>(c)]);
        faces_.triangles.push_back(triangle);
        faces_.tags.push_back(cluster_->tags[k]);
        return triangle;
    }

  private:
    uint32_t vertex(uint8_t v) {
        if (local_[v] != no_index) return local_[v];
        local_[v] = numbers_.add(cluster_->vertices[v]);
        if (local_[v] == faces_.vertices.size()) {
            faces_.vertices.push_back(cluster_->vertices[v]);
            faces_.positions.push_back(cluster_->positions[v]);
        }
        return local_[v];
    }

    FaceList& faces_;
    NumberTable& numbers_;
    const Cluster* cluster_ = nullptr;
    std::array<uint32_t, 256> local_{}; // by vertex of the cluster
};

} // namespace brittle::fracture
